//! How large a file and what it holds may be: every limit of the readers with its reason, in one place.

use crate::bodies::MAX_TRIANGLES;

/// A number that no file may exceed.
#[derive(Debug, Clone, Copy)]
pub struct Limit {
    /// What is counted, as messages and the documents name it.
    pub of: &'static str,
    pub most: usize,
    /// Why no file needs more.
    pub reason: &'static str,
    /// What to do with a file that has more.
    pub cure: &'static str,
}

impl Limit {
    const fn new(most: usize, of: &'static str, reason: &'static str, cure: &'static str) -> Limit {
        Limit { of, most, reason, cure }
    }

    /// The message for a number above the limit.
    pub fn exceeded(&self, found: usize) -> Option<String> {
        (found > self.most).then(|| format!("{found} {}; at most {} are allowed, {}", self.of, self.most, self.cure))
    }

    /// Largest size of a file in whole megabytes.
    pub const fn megabytes(&self) -> usize {
        self.most >> 20
    }
}

pub const YAML_BYTES: Limit =
    Limit::new(4 << 20, "bytes of a YAML, URDF or shard file", "the largest shipped is a hundredth of it", "split it");
pub const CSV_BYTES: Limit =
    Limit::new(128 << 20, "bytes of a recording", "the rows below with ten columns", "average its rows");
pub const MESH_BYTES: Limit =
    Limit::new(64 << 20, "bytes of a mesh file", "a text STL of the triangles below", "simplify the mesh");

pub const DEPTH: Limit =
    Limit::new(40, "levels of brackets and indentation", "no key stands half as deep", "flatten it");
pub const XML_DEPTH: Limit = Limit::new(64, "levels of a robot description", "parsers recurse over it", "flatten it");
pub const TEXT: Limit =
    Limit::new(1000, "characters of one text", "names and quantities are short", "write a shorter text");
pub const TEST_NAME: Limit =
    Limit::new(200, "bytes of a test's name", "recordings are files named after tests", "write a shorter name");

pub const AXES: Limit = Limit::new(24, "axes of a chain", "three arms of a robot", "leave out what stands still");
pub const LINKS: Limit =
    Limit::new(1000, "links of a machine", "a humanoid has a tenth of it", "leave out links that nothing names");
pub const ELEMENTS: Limit =
    Limit::new(50_000, "elements of a robot description", "fifty for each link", "leave out what is only drawn");
pub const ATTRIBUTES: Limit =
    Limit::new(32, "attributes of an element", "no element of the format has more than 6", "remove the others");
pub const FORM_TERMS: Limit =
    Limit::new(100, "terms of a component error", "each is worked out for every row", "write a table instead");
pub const TABLE_ROWS: Limit = Limit::new(
    10_000,
    "rows of a component error's table",
    "a row for every 0.1 mm of a metre",
    "leave out rows on straight lines",
);
pub const EFFECTS: Limit = Limit::new(1000, "effects of a machine", "each is worked out for every row", "write fewer");
pub const EFFECT_LIST: Limit = Limit::new(1000, "numbers of a list", "no effect has more", "write fewer numbers");

pub const SOLIDS: Limit =
    Limit::new(400, "solids of a machine, pieces of meshes counted", "all pairs are compared", "simplify the bodies");
pub const MOUNTS: Limit =
    Limit::new(100, "mounting surfaces", "a plan searches each of them", "name those that are used");
pub const HULL_POINTS: Limit =
    Limit::new(10_000, "corners of a hull", "hulls keep 256 corners", "leave out the inner ones");
pub const TRIANGLES: Limit =
    Limit::new(MAX_TRIANGLES, "triangles of a mesh", "a machine's cover needs a tenth", "simplify the mesh");
pub const MESHES: Limit =
    Limit::new(100, "different mesh files of a machine", "each is cut into convex pieces once", "join the meshes");
pub const EXTENSIONS: Limit =
    Limit::new(6, "extensions of a kit", "lengths double with each", "name those that are used");
pub const KIT_LIST: Limit =
    Limit::new(20, "lengths of a kit's list", "a plan tries every one", "name those that are used");

pub const TESTS: Limit = Limit::new(5000, "tests of a session", "a year of weekly runs", "split the session");
pub const SETUPS: Limit = Limit::new(
    300,
    "setups of pivots, spindle balls and bars",
    "each adds up to three unknowns, and a fit grows with their cube",
    "split the session",
);
pub const ROWS: Limit = Limit::new(
    1_000_000,
    "rows of a recording or samples of a path",
    "a quarter of an hour at 1000 readings a second",
    "average the readings of every few rows or make the step wider",
);
pub const SESSION_ROWS: Limit = Limit::new(
    2_000_000,
    "rows of all tests together",
    "a fit takes about 0.5 kB and 25 µs for a row",
    "average the readings of every few rows or split the session",
);
pub const COLUMNS: Limit =
    Limit::new(100, "columns of a recording", "axes, clock, length and some channels", "remove columns");
pub const LINE_BYTES: Limit =
    Limit::new(10_000, "bytes of a line", "100 columns of 100 characters", "check the file's line ends");

pub const CAPTURE_SECONDS: Limit =
    Limit::new(86_400, "seconds of a capture", "two runs take minutes", "check the unit of its times, or its rate");

/// All limits in the order of the documents.
pub const ALL: [Limit; 29] = [
    YAML_BYTES,
    CSV_BYTES,
    MESH_BYTES,
    DEPTH,
    XML_DEPTH,
    TEXT,
    TEST_NAME,
    AXES,
    LINKS,
    ELEMENTS,
    ATTRIBUTES,
    FORM_TERMS,
    TABLE_ROWS,
    EFFECTS,
    EFFECT_LIST,
    SOLIDS,
    MOUNTS,
    HULL_POINTS,
    TRIANGLES,
    MESHES,
    EXTENSIONS,
    KIT_LIST,
    TESTS,
    SETUPS,
    ROWS,
    SESSION_ROWS,
    COLUMNS,
    LINE_BYTES,
    CAPTURE_SECONDS,
];
