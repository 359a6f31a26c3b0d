//! Sets of real recordings: where their machine, their session and their rows are.

use std::path::{Path, PathBuf};

use fiveaxis::load::load_session;
use fiveaxis::session::Session;

/// A set of real recordings.
pub struct Set {
    pub name: &'static str,
    /// Folder of machine and session within `examples/real`.
    folder: &'static str,
    /// File of the rows in the folder of the data, or a folder of files; none: they are part of the project.
    rows: Option<&'static str>,
    /// Rows of a block.
    pub block: usize,
    /// A fourth joint of a torso turns back what the second and the third did, and has no column: Justin's.
    is_coupled: bool,
    /// What a fit by an expert reached on other rows, mm.
    pub by_hand_mm: &'static str,
}

/// All of them.
pub const SETS: [Set; 13] = [
    shipped("positioner", "positioner", 5, "0.278"),
    shipped("ur10-d", "ur10-d", 5, "0.356"),
    with_rows("ur10-b", "ur10-d", "ur10/series_b.csv", "0.380"),
    with_rows("ur10-c", "ur10-d", "ur10/series_c.csv", "0.469"),
    with_rows("iiwa-0kg", "rows-elsewhere/iiwa7", "iiwa7/run_0kg.csv", "0.334"),
    with_rows("iiwa-1.25kg", "rows-elsewhere/iiwa7", "iiwa7/run_1.25kg.csv", "0.347"),
    with_rows("iiwa-2.5kg", "rows-elsewhere/iiwa7", "iiwa7/run_2.5kg.csv", "0.349"),
    with_rows("iiwa-november", "rows-elsewhere/iiwa7", "iiwa7/run_nov.csv", "0.296"),
    shipped("panda-1", "sockets-panda/panda-1", 3, "0.413"),
    shipped("panda-3", "sockets-panda/panda-3", 3, "0.159"),
    with_rows("jaibot", "rows-elsewhere/jaibot", "jaibot/flat.csv", "2.38"),
    Set { is_coupled: true, ..with_rows("justin", "rows-elsewhere/justin", "justin/points.csv", "3.12 (mean)") },
    Set { block: 50, ..with_rows("wheel", "rows-elsewhere/wheel", "wheel", "0.019-0.029") },
];

const fn shipped(name: &'static str, folder: &'static str, block: usize, by_hand_mm: &'static str) -> Set {
    Set { name, folder, rows: None, block, is_coupled: false, by_hand_mm }
}

const fn with_rows(name: &'static str, folder: &'static str, rows: &'static str, by_hand_mm: &'static str) -> Set {
    Set { name, folder, rows: Some(rows), block: 5, is_coupled: false, by_hand_mm }
}

impl Set {
    /// Its session with all rows; `None` where the rows are not in the folder of the data.
    pub fn session(&self, data: &Path) -> Option<Session> {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/real").join(self.folder);
        let Some(rows) = self.rows else { return Some(load_session(&folder.join("session.yaml")).expect("a session")) };
        let rows = data.join(rows);
        let together = tempfile::tempdir().expect("a folder");
        for name in ["machine.yaml", "session.yaml"] {
            std::fs::copy(folder.join(name), together.path().join(name)).expect("a copy");
        }
        let copied = |file: &Path, name: &str| {
            let text = std::fs::read_to_string(file).ok()?;
            let text = if self.is_coupled { coupled(&numbers(&text)) } else { numbers(&text) };
            std::fs::write(together.path().join(name), text).ok()
        };
        match std::fs::read_dir(&rows) {
            Err(_) => copied(&rows, "points.csv")?,
            Ok(files) => {
                for file in files.flatten() {
                    copied(&file.path(), &file.file_name().to_string_lossy())?;
                }
            }
        }
        Some(load_session(&together.path().join("session.yaml")).expect("a session"))
    }
}

/// A table without its columns of words; a column of positions is named after its axis alone.
fn numbers(text: &str) -> String {
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let is_number = |cell: &str| cell.is_empty() || cell.parse::<f64>().is_ok();
    let is_kept = |column: usize| rows.iter().skip(1).all(|row| row.get(column).is_none_or(|cell| is_number(cell)));
    let kept: Vec<usize> = (0..rows.first().map_or(0, Vec::len)).filter(|&column| is_kept(column)).collect();
    let line = |row: &Vec<&str>| {
        let cells: Vec<&str> = kept.iter().filter_map(|&column| row.get(column).copied()).collect();
        cells.join(",") + "\n"
    };
    let text: String = rows.iter().map(line).collect();
    // accelerations that are named after the column are no positions of it
    text.replacen(",column_mm,", ",lift_mm,", 1)
}

/// With a column for the joint T3 at −(q1 + q2); markers beside `second` are left out.
fn coupled(text: &str) -> String {
    let header: Vec<&str> = text.lines().next().unwrap_or_default().split(',').collect();
    let place = |name: &str| header.iter().position(|other| *other == name).expect("a column");
    let joints = [place("q1_deg"), place("q2_deg")];
    let is_kept = |name: &&str| !name.starts_with("first_");
    let row = |(row, line): (usize, &str)| {
        let cells: Vec<&str> = line.split(',').collect();
        let kept = header.iter().zip(&cells).filter(|(name, _)| is_kept(name)).map(|(_, cell)| *cell);
        let own = match row {
            0 => "T3_deg".to_string(),
            _ => {
                let turned: f64 = joints.iter().map(|&joint| cells[joint].parse::<f64>().expect("an angle")).sum();
                format!("{}", -turned)
            }
        };
        kept.collect::<Vec<&str>>().join(",") + "," + &own + "\n"
    };
    text.lines().enumerate().map(row).collect()
}
