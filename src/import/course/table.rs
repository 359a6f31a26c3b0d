//! Values that are looked up together between two rows of a table. What they are is the caller's.

/// Values by node, those of one node behind each other: what is looked up together stands together.
#[derive(Debug, Clone)]
pub struct Table {
    columns: usize,
    values: Vec<f64>,
}

impl Table {
    /// Of columns of one length, of two rows at least.
    pub fn of_columns<C: AsRef<[f64]>>(columns: &[C]) -> Table {
        let rows = columns.first().map_or(0, |column| column.as_ref().len());
        let values = (0..rows).flat_map(|row| columns.iter().map(move |column| column.as_ref()[row])).collect();
        Table { columns: columns.len(), values }
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    pub fn is_empty(&self) -> bool {
        self.columns == 0
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.columns.max(1)
    }

    /// Value of one column at a row with its fraction.
    pub fn value(&self, at: f64, column: usize) -> f64 {
        self.at(at).nth(column).unwrap_or(0.0)
    }

    /// All columns at a row with its fraction.
    pub fn at(&self, at: f64) -> impl Iterator<Item = f64> {
        // a negative row is the first one
        let before = (at as usize).min(self.rows().saturating_sub(2));
        let share = at - before as f64;
        let rows = self.values.get(before * self.columns..(before + 2) * self.columns).unwrap_or_default();
        let (one, next) = rows.split_at(rows.len() / 2);
        one.iter().zip(next).map(move |(one, next)| one + share * (next - one))
    }
}
