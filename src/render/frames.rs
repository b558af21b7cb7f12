//! A flip-book: the scenes of sun or camera that swing from side to side.

use super::scene::Scene;
use std::f64::consts::TAU;

/// What moves in a flip-book.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turning {
    /// The sun, in its azimuth; the camera stays.
    Sun,
    /// The camera.
    View,
}

/// `frames` scenes, in which the angle swings as `reach · sin` about 0 through one period, so that the last is followed by the
/// first.
///
/// ```
/// use morpho_fit::render::{Scene, Turning, turned};
/// let scenes = turned(&Scene::vertical_sun(0.2), Turning::Sun, 1.0, 4);
/// assert_eq!(scenes.len(), 4);
/// assert!((scenes[1].sun - 1.0).abs() < 1e-12 && (scenes[3].sun + 1.0).abs() < 1e-12 && scenes[2].view == 0.2);
/// ```
#[must_use]
pub fn turned(scene: &Scene, turning: Turning, reach: f64, frames: usize) -> Vec<Scene> {
    #[allow(clippy::cast_precision_loss, reason = "a few hundred frames")]
    let angle = |frame: usize| reach * (TAU * frame as f64 / frames as f64).sin();
    let one = |frame| match turning {
        Turning::Sun => Scene { sun: angle(frame), ..*scene },
        Turning::View => Scene { view: angle(frame), ..*scene },
    };
    (0..frames).map(one).collect()
}
