//! What a program does, step by step, and which curves a control draws by itself. No control's words.

/// One thing a program does.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// Words for the operator.
    Say(String),
    /// Stop until the operator goes on.
    Stop(String),
    /// Move one axis fast; position in mm or deg.
    Rapid { axis: String, to: f64 },
    /// Move one axis; position in mm or deg, feed in mm/min or deg/min.
    Feed { axis: String, to: f64, per_minute: f64 },
    /// Move several axes on a straight line; positions in mm or deg, and the time it takes, min.
    Move { to: Vec<(String, f64)>, minutes: f64 },
    /// An arc of two linear axes, the one that carries the cosine first; centre and end relative to where it begins, mm; whole
    /// turns before the end; a rotary axis that turns evenly with it, by deg; feed along the arc.
    Arc {
        axes: [String; 2],
        centre: [f64; 2],
        end: [f64; 2],
        counter_clockwise: bool,
        turns: u32,
        turn: Option<(String, f64)>,
        feed_mm_per_min: f64,
    },
    /// Wait, s.
    Dwell(f64),
}

/// Which curves a control draws by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curves {
    /// Arcs in all coordinate planes, a rotary axis carried along, less than a turn in a block.
    Carrying,
    /// The same with any number of turns in a block.
    Winding,
    /// Arcs in XY and YZ. Conversational tells no sense of arcs across the working plane beyond all doubt in ZX, and its arcs
    /// carry no rotary axis.
    Plain,
}
