//! Rows of a test that are kept: half of them in a fold. Products run over those alone. What a filter does with the others is for it.

/// Share of the rows up to which the kept ones are taken out: where more are kept, leaving the rest out costs as much as it spares.
const WORTH_TAKING_OUT: f64 = 0.75;

/// The rows of a test that are kept, or all where nearly all are: a filter makes the others zero.
pub struct KeptRows {
    all: usize,
    /// Which they are; `None` where all are.
    some: Option<Vec<usize>>,
}

impl KeptRows {
    /// Those where `kept` holds. Where there are none it is the first one, which every filter makes zero: no column is without rows.
    pub fn of(kept: &[bool]) -> KeptRows {
        let mut some: Vec<usize> = (0..kept.len()).filter(|&row| kept[row]).collect();
        if some.is_empty() && !kept.is_empty() {
            some.push(0);
        }
        let is_worth_it = (some.len() as f64) < WORTH_TAKING_OUT * kept.len() as f64;
        KeptRows { all: kept.len(), some: is_worth_it.then_some(some) }
    }

    /// How many there are with those that are not kept.
    pub fn all(&self) -> usize {
        self.all
    }

    /// How many they are.
    pub fn count(&self) -> usize {
        self.some.as_ref().map_or(self.all, Vec::len)
    }

    /// Leaves the kept rows of columns that lie one after the other.
    pub fn gather(&self, columns: &mut Vec<f64>) {
        let Some(some) = &self.some else { return };
        let mut to = 0;
        for from in (0..columns.len()).step_by(self.all) {
            for row in some {
                columns[to] = columns[from + row];
                to += 1;
            }
        }
        columns.truncate(to);
    }

    /// Gives a column its rows back; those that are not kept are zero.
    pub fn spread(&self, column: &mut Vec<f64>) {
        let Some(some) = &self.some else { return };
        let mut all = vec![0.0; self.all];
        some.iter().zip(column.iter()).for_each(|(&row, value)| all[row] = *value);
        *column = all;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_rows_are_taken_out_and_put_back() {
        let kept = KeptRows::of(&[true, false, true, false]);
        let mut columns = vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
        kept.gather(&mut columns);
        assert_eq!((columns.as_slice(), kept.count()), ([1.0, 3.0, 5.0, 7.0].as_slice(), 2));
        let mut column = vec![1.0, 3.0];
        kept.spread(&mut column);
        assert_eq!(column, [1.0, 0.0, 3.0, 0.0]);
        assert_eq!(KeptRows::of(&[false, false]).count(), 1);
        let mut all = vec![1.0, 2.0];
        KeptRows::of(&[true, true]).gather(&mut all);
        assert_eq!(all, [1.0, 2.0]);
    }
}
