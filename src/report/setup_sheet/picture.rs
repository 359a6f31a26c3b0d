//! A setup seen from one side, drawn to scale: machine, instrument, ways of the balls, names, scale bar. It computes nothing.

use std::fmt::Write as _;

use crate::report::wording::markup::escape;

/// A part in a view.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    pub name: String,
    /// Ball bar, cups, stand; else the machine.
    pub instrument: bool,
    /// Polygon, right and up, mm.
    pub points: Vec<[f64; 2]>,
}

/// A machine with its instrument seen from one side, in the middle of the arc.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// `from the front`.
    pub side: String,
    /// Directions of R to the right and up: `x`, `-y`.
    pub right: String,
    pub up: String,
    /// Pivot ball and spindle ball, right and up, mm.
    pub balls: [[f64; 2]; 2],
    /// Where each goes over the arc.
    pub ways: [Vec<[f64; 2]>; 2],
    pub outlines: Vec<Outline>,
}

/// Least half of the picture's edge, mm on the machine.
const LEAST_HALF_MM: f64 = 190.0;
/// Room around the instrument and its ways.
const ROOM: f64 = 1.35;
/// Height of a machine part's name, half pictures.
const NAME: f64 = 0.056;
/// Lengths for the scale bar, mm.
const SCALES_MM: [f64; 5] = [50.0, 100.0, 200.0, 500.0, 1000.0];

/// The square that a picture shows: middle and half of its edge, mm.
struct Frame {
    middle: [f64; 2],
    half: f64,
}

impl Frame {
    fn of(view: &View) -> Frame {
        let instrument = view.outlines.iter().filter(|outline| outline.instrument).flat_map(|outline| &outline.points);
        let points = instrument.chain(view.ways.iter().flatten()).chain(&view.balls);
        let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
        for point in points {
            for k in 0..2 {
                low[k] = low[k].min(point[k]);
                high[k] = high[k].max(point[k]);
            }
        }
        let half = 0.5 * ROOM * (high[0] - low[0]).max(high[1] - low[1]);
        Frame { middle: [0, 1].map(|k| 0.5 * (low[k] + high[k])), half: half.max(LEAST_HALF_MM) }
    }

    /// The middle of a text, moved so that all of it is in the picture.
    fn inside(&self, at: [f64; 2], words: &str, size: f64) -> [f64; 2] {
        let room = (0.97 * self.half - half_width(words, size)).max(0.0);
        [at[0].clamp(self.middle[0] - room, self.middle[0] + room), at[1]]
    }

    /// Where the name of an outline stands: in the middle of what is seen of it; `None` for what is hardly seen and for
    /// what fills the picture.
    fn name_at(&self, outline: &Outline) -> Option<[f64; 2]> {
        let ends = [0, 1].map(|k| {
            let inside = outline
                .points
                .iter()
                .map(|point| point[k])
                .fold((f64::MAX, f64::MIN), |ends, x| (ends.0.min(x), ends.1.max(x)));
            let room = 0.97 * self.half;
            (inside.0.max(self.middle[k] - room), inside.1.min(self.middle[k] + room))
        });
        let sizes = ends.map(|(low, high)| (high - low) / self.half);
        let fits = sizes.iter().all(|size| *size > 0.08) && sizes.iter().any(|size| *size < 1.9);
        fits.then(|| self.inside(ends.map(|(low, high)| 0.5 * (low + high)), &outline.name, NAME * self.half))
    }
}

/// About half the width of a text, mm: a letter is half as wide as high.
fn half_width(words: &str, size: f64) -> f64 {
    0.25 * size * words.chars().count() as f64
}

/// One picture; `pair` is what comes closest.
pub(super) fn picture(out: &mut String, view: &View, bar_mm: f64, pair: &(String, String)) {
    let frame = Frame::of(view);
    let Frame { middle: [x, y], half } = frame;
    let _ = write!(
        out,
        "<figure><figcaption>{0}</figcaption><svg viewBox=\"{1:.1} {2:.1} {3:.1} {4:.1}\" role=\"img\" aria-label=\"{0}\">",
        escape(&view.side),
        x - half,
        -y - half,
        2.0 * half,
        2.0 * half,
    );
    for outline in &view.outlines {
        let close = outline.name == pair.0 || outline.name == pair.1;
        let look = match (outline.instrument, close) {
            (true, _) => "fill=\"#c33\" fill-opacity=\".75\" stroke=\"#600\"",
            (false, true) => "fill=\"#c80\" fill-opacity=\".30\" stroke=\"#640\"",
            (false, false) => "fill=\"#678\" fill-opacity=\".15\" stroke=\"#345\"",
        };
        let _ = write!(
            out,
            "<polygon {look} stroke-width=\"{:.2}\" points=\"{}\"><title>{}</title></polygon>",
            half * 0.004,
            path(&outline.points),
            escape(&outline.name)
        );
    }
    for way in &view.ways {
        let _ = write!(
            out,
            "<polyline fill=\"none\" stroke=\"#06c\" stroke-width=\"{:.2}\" stroke-dasharray=\"{:.1} {:.1}\" points=\"{}\"/>",
            half * 0.008,
            half * 0.03,
            half * 0.02,
            path(way)
        );
    }
    for ball in view.balls {
        let _ = write!(
            out,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{:.1}\" fill=\"#111\"/>",
            ball[0],
            -ball[1],
            half * 0.022
        );
    }
    names(out, view, &frame, bar_mm);
    directions(out, view, &frame);
    scale(out, &frame);
    out.push_str("</svg></figure>");
}

fn path(points: &[[f64; 2]]) -> String {
    points.iter().map(|point| format!("{:.1},{:.1}", point[0], -point[1])).collect::<Vec<_>>().join(" ")
}

/// Text with a pale edge, so that it can be read over anything.
fn text(out: &mut String, at: [f64; 2], size: f64, anchor: &str, words: &str) {
    let _ = write!(
        out,
        "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{size:.1}\" text-anchor=\"{anchor}\" paint-order=\"stroke\" stroke=\"#fff\" stroke-width=\"{:.1}\" stroke-linejoin=\"round\">{}</text>",
        at[0],
        -at[1],
        size * 0.3,
        escape(words)
    );
}

/// Names of balls, bar and machine parts.
fn names(out: &mut String, view: &View, frame: &Frame, bar_mm: f64) {
    let size = frame.half * 0.075;
    let [pivot, spindle] = view.balls;
    let bar = [0, 1].map(|k| 0.5 * (pivot[k] + spindle[k]));
    let words = ["pivot ball", "spindle ball", &format!("bar {bar_mm} mm")];
    let along = [spindle[0] - pivot[0], spindle[1] - pivot[1]];
    let steep = along[1].abs() > along[0].abs() || along[0].abs() < size;
    let beside = |sign: f64, words: &str| sign * (half_width(words, size) + 0.5 * size);
    let at = if steep {
        // the upper name above its ball, the lower one below, the bar's to the right
        let (above, below) = (0.6 * size, -1.3 * size);
        let [of_pivot, of_spindle] = if along[1] < -1e-6 { [above, below] } else { [below, above] };
        [
            [pivot[0], pivot[1] + of_pivot],
            [spindle[0], spindle[1] + of_spindle],
            [bar[0] + beside(1.0, words[2]), bar[1] - 0.35 * size],
        ]
    } else {
        // outward to the left and right, the bar's below
        let sign = along[0].signum();
        [
            [pivot[0] + beside(-sign, words[0]), pivot[1] + 0.3 * size],
            [spindle[0] + beside(sign, words[1]), spindle[1] + 0.3 * size],
            [bar[0], bar[1] - 1.4 * size],
        ]
    };
    let at = [0, 1, 2].map(|k| frame.inside(at[k], words[k], size));
    let mut taken = vec![at[0], at[1], at[2], bar];
    let mut named: Vec<&str> = Vec::new();
    for outline in view.outlines.iter().filter(|outline| !outline.instrument) {
        let Some(at) = frame.name_at(outline).filter(|_| !named.contains(&outline.name.as_str())) else { continue };
        if taken.iter().all(|other| (other[0] - at[0]).abs() > 5.0 * size || (other[1] - at[1]).abs() > 1.3 * size) {
            taken.push(at);
            named.push(&outline.name);
            text(out, at, NAME * frame.half, "middle", &outline.name);
        }
    }
    at.into_iter().zip(words).for_each(|(at, words)| text(out, at, size, "middle", words));
}

/// Arrows of R's directions.
fn directions(out: &mut String, view: &View, frame: &Frame) {
    let Frame { middle: [x, y], half } = *frame;
    let size = half * 0.08;
    let foot = [x - 0.9 * half, y - 0.9 * half];
    for (to, name, anchor) in [
        ([foot[0] + 0.25 * half, foot[1]], &view.right, "start"),
        ([foot[0], foot[1] + 0.25 * half], &view.up, "middle"),
    ] {
        let _ = write!(
            out,
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"#111\" stroke-width=\"{:.2}\"/>",
            foot[0],
            -foot[1],
            to[0],
            -to[1],
            half * 0.012
        );
        let way = [(to[0] - foot[0]) / (0.25 * half), (to[1] - foot[1]) / (0.25 * half)];
        let tip = |along: f64, aside: f64| {
            [to[0] + half * (way[0] * along - way[1] * aside), to[1] + half * (way[1] * along + way[0] * aside)]
        };
        let _ = write!(
            out,
            "<polygon fill=\"#111\" points=\"{}\"/>",
            path(&[tip(0.05, 0.0), tip(0.0, 0.025), tip(0.0, -0.025)])
        );
        let beyond = tip(0.08, 0.0);
        let down = if anchor == "start" { -0.35 * size } else { 0.0 };
        text(out, [beyond[0], beyond[1] + down], size, anchor, name);
    }
}

/// A length to compare with.
fn scale(out: &mut String, frame: &Frame) {
    let Frame { middle: [x, y], half } = *frame;
    let length = SCALES_MM.into_iter().rfind(|length| *length <= 0.6 * half).unwrap_or(SCALES_MM[0]);
    let (right, low) = (x + 0.93 * half, y - 0.9 * half);
    let tick = 0.025 * half;
    let _ = write!(
        out,
        "<path fill=\"none\" stroke=\"#111\" stroke-width=\"{:.2}\" d=\"M{:.1} {:.1}v{:.1}M{:.1} {:.1}h{length}M{:.1} {:.1}v{:.1}\"/>",
        half * 0.012,
        right - length,
        -low - tick,
        2.0 * tick,
        right - length,
        -low,
        right,
        -low - tick,
        2.0 * tick
    );
    text(out, [right - 0.5 * length, low + 0.05 * half], half * 0.07, "middle", &format!("{length} mm"));
}
