//! A ball of a link that sits in a socket: at every row its centre is where it was before. No instrument.
//!
//! The place of the socket is unknown; the coordinates of the ball from it, along R's directions, are zero.

use super::scalar::Scalar;

pub(super) const NAME: &str = "same_point";
pub(super) const SCALARS: [Scalar; 3] = [Scalar::Coordinate(0), Scalar::Coordinate(1), Scalar::Coordinate(2)];
