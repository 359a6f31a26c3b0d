//! Columns of text aligned for a terminal; knows nothing of what stands in them.

/// A table: a header and rows of the same number of cells.
#[derive(Debug, Clone, Default)]
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with a header.
    pub fn new(header: &[&str]) -> Table {
        Table { rows: vec![header.iter().map(|cell| cell.to_string()).collect()] }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// The table as text: first column to the left, numbers to the right, a line under the header.
    pub fn text(&self) -> String {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            self.rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let is_number = |column: usize| {
            self.rows
                .iter()
                .skip(1)
                .filter_map(|row| row.get(column))
                .all(|cell| cell.is_empty() || cell.starts_with(|c: char| c.is_ascii_digit() || "+-±–".contains(c)))
        };
        let right: Vec<bool> = (0..columns).map(|column| column > 0 && is_number(column)).collect();
        let mut text = String::new();
        for (index, row) in self.rows.iter().enumerate() {
            let mut line = String::from("  ");
            for (column, cell) in row.iter().enumerate() {
                let pad = " ".repeat(widths[column] - cell.chars().count());
                if right[column] {
                    line.push_str(&pad);
                    line.push_str(cell);
                } else {
                    line.push_str(cell);
                    line.push_str(&pad);
                }
                line.push_str("  ");
            }
            text.push_str(line.trim_end());
            text.push('\n');
            if index == 0 {
                let total: usize = widths.iter().sum::<usize>() + 2 * (columns.max(1) - 1);
                text.push_str(&format!("  {}\n", "─".repeat(total)));
            }
        }
        text
    }
}
