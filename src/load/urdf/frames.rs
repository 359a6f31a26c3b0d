//! Lengths, angles and frames of a robot description as a machine file would state them: mm, whole decimals, quarter turns.

use nalgebra::{Matrix3, Vector3};

/// Millimetres in a metre.
pub(super) const MM_PER_M: f64 = 1000.0;
/// Lengths are kept to a picometre: 0.07 m is 70 mm and not 70.00000000000001.
const GRAINS_PER_MM: f64 = 1e9;

/// Pose of a link in R with all joints at zero.
#[derive(Clone, Copy)]
pub(super) struct Placed {
    pub rotation: Matrix3<f64>,
    pub at_mm: Vector3<f64>,
}

pub(super) fn millimetres(metres: f64) -> f64 {
    grain(metres * MM_PER_M)
}

pub(super) fn grain(length_mm: f64) -> f64 {
    (length_mm * GRAINS_PER_MM).round() / GRAINS_PER_MM
}

/// Ends of a range are kept to 1e-7 degrees: ten printed decimals of a radian mean 165° and not 165.000000002°.
pub(super) fn whole_degrees(angle_rad: f64) -> f64 {
    const PER_DEGREE: f64 = 1e7;
    ((angle_rad.to_degrees() * PER_DEGREE).round() / PER_DEGREE).to_radians()
}

/// `R = Rz(yaw)·Ry(pitch)·Rx(roll)`, the URDF's fixed-axis order.
pub(super) fn roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> Matrix3<f64> {
    *nalgebra::Rotation3::from_euler_angles(roll, pitch, yaw).matrix()
}

/// Angles that are a multiple of 45° rounded to their printed decimals are taken as that multiple.
///
/// Files print 1.5708 for a quarter turn; taken literally the axis would lean by 0.76 arcsec and count as inclined.
pub(super) fn quarter_turns(text: &str, angles: [f64; 3]) -> [f64; 3] {
    let words: Vec<&str> = text.split_whitespace().collect();
    let mut taken = angles;
    for (angle, word) in taken.iter_mut().zip(words) {
        let decimals = word.split_once('.').map_or(0, |(_, digits)| digits.len());
        let is_plain = !word.contains(['e', 'E']);
        let eighth = std::f64::consts::FRAC_PI_4;
        let multiple = (*angle / eighth).round() * eighth;
        if is_plain && decimals >= 2 && (*angle - multiple).abs() <= 0.5000001 * 10f64.powi(-(decimals.min(17) as i32))
        {
            *angle = multiple;
        }
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_quarter_turns_are_quarter_turns() {
        let taken = |text: &str| {
            let angles: Vec<f64> = text.split(' ').map(|word| word.parse().unwrap()).collect();
            quarter_turns(text, [angles[0], angles[1], angles[2]])
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        assert_eq!(taken("1.5708 0.785398 0.1"), [quarter, quarter / 2.0, 0.1]);
        assert_eq!(taken("1.571 1.5709 3.14"), [quarter, 1.5709, 2.0 * quarter]);
        assert_eq!(millimetres(0.07), 70.0);
        assert_eq!(millimetres(0.302), 302.0);
    }
}
