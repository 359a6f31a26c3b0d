//! Values that are looked up together between two rows of a table. What they are is the caller's.

/// Values by node, those of one node behind each other: what is looked up together stands together.
#[derive(Debug, Clone)]
pub struct Table {
    columns: usize,
    rows: usize,
    values: Vec<f64>,
}

/// A place between two rows of a table.
#[derive(Clone, Copy)]
pub(super) struct Between<'t> {
    /// Part of the way from one row to the next.
    share: f64,
    one: &'t [f64],
    next: &'t [f64],
}

impl Table {
    /// Of columns of one length, of two rows at least.
    pub fn of_columns<C: AsRef<[f64]>>(columns: &[C]) -> Table {
        let rows = columns.first().map_or(0, |column| column.as_ref().len());
        let values = (0..rows).flat_map(|row| columns.iter().map(move |column| column.as_ref()[row])).collect();
        Table { columns: columns.len(), rows, values }
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
        self.rows
    }

    /// A row with its fraction; a negative one is the first.
    pub(super) fn between(&self, at: f64) -> Between<'_> {
        let before = (at as usize).min(self.rows.saturating_sub(2));
        let rows = self.values.get(before * self.columns..(before + 2) * self.columns).unwrap_or_default();
        let (one, next) = rows.split_at(rows.len() / 2);
        Between { share: at - before as f64, one, next }
    }

    /// All columns at a row with its fraction, into as many places.
    pub fn write(&self, at: f64, to: &mut [f64]) {
        self.between(at).write(0, to);
    }
}

impl Between<'_> {
    /// Value of one column; zero where there is none.
    pub fn value(self, column: usize) -> f64 {
        match (self.one.get(column), self.next.get(column)) {
            (Some(one), Some(next)) => one + self.share * (next - one),
            _ => 0.0,
        }
    }

    /// Values from a column on, into places.
    pub fn write(self, from: usize, to: &mut [f64]) {
        let (one, next) = (self.one.get(from..).unwrap_or_default(), self.next.get(from..).unwrap_or_default());
        to.iter_mut().zip(one.iter().zip(next)).for_each(|(to, (one, next))| *to = one + self.share * (next - one));
    }
}
