//! Where wing, sun and camera are: the numbers that a picture and an exported scene share.
//!
//! The wing is a square in the plane z = 0 with its centre in the origin; +x is the right of the maps, +y their upper side.
//! The camera looks at the origin from `(0, -sin view, cos view) · 6`, its upper side towards +y: at a view of 0 it sees the
//! square from above, at 60° from below its lower edge, as in the paper's Fig. 15. The sun is far away.

use super::error::RenderError;
use std::f64::consts::FRAC_PI_2;

/// Half the side of the square, which gives the scene its unit.
pub const HALF_SIDE: f64 = 1.0;
/// Distance of the camera from the origin.
pub const CAMERA_DISTANCE: f64 = 6.0;
/// Field of view along the shorter side of the picture, degrees: at a view of 0 the square fills 94.5 % of it,
/// `1 / (6 tan 10°)`.
pub const FIELD_OF_VIEW: f64 = 20.0;

/// Sun and camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scene {
    /// Angle of the camera from the normal of the wing, rad; positive below the lower edge.
    pub view: f64,
    /// Angle of the sun from the normal of the wing, rad.
    pub sun: f64,
    /// Azimuth of the sun, rad counterclockwise from +x; -pi/2 is on the side of the camera.
    pub azimuth: f64,
}

impl Scene {
    /// The paper's scene: a vertical sun, and the camera at `view`, rad.
    #[must_use]
    pub fn vertical_sun(view: f64) -> Self {
        Self { view, sun: 0.0, azimuth: -FRAC_PI_2 }
    }

    /// # Errors
    /// [`RenderError::OutOfRange`] for a camera or a sun that is not in front of the wing.
    pub fn validate(&self) -> Result<(), RenderError> {
        for (quantity, found) in [("the angle of the view, rad,", self.view), ("the angle of the sun, rad,", self.sun)]
        {
            let is_in_front = found.abs() < FRAC_PI_2;
            if !is_in_front {
                return Err(RenderError::OutOfRange { quantity, found, allowed: "less than 90° in size" });
            }
        }
        if !self.azimuth.is_finite() {
            let (quantity, found) = ("the azimuth of the sun, rad,", self.azimuth);
            return Err(RenderError::OutOfRange { quantity, found, allowed: "any finite number" });
        }
        Ok(())
    }

    /// Unit vector from the wing to the sun.
    ///
    /// ```
    /// use morpho_fit::render::Scene;
    /// assert_eq!(Scene::vertical_sun(0.5).to_sun(), [0.0, -0.0, 1.0]);
    /// ```
    #[must_use]
    pub fn to_sun(&self) -> [f64; 3] {
        let (sin, cos) = self.sun.sin_cos();
        [sin * self.azimuth.cos(), sin * self.azimuth.sin(), cos]
    }

    /// Unit vector from the origin to the camera.
    #[must_use]
    pub fn to_camera(&self) -> [f64; 3] {
        let (sin, cos) = self.view.sin_cos();
        [0.0, -sin, cos]
    }

    /// Where the ray through a point of the picture meets the plane of the wing, and the unit vector from there to the camera;
    /// none if it misses the plane.
    ///
    /// - `point`: pixels from the left and from the top, the first pixel from 0 to 1; `size`: width and height, pixels.
    ///
    /// ```
    /// use morpho_fit::render::{HALF_SIDE, Scene};
    /// let (at, up) = Scene::vertical_sun(0.0).ray([200.0, 100.0], [400.0, 200.0]).unwrap();
    /// assert!(at[0].abs() < 1e-12 && at[1].abs() < 1e-12 && (up[2] - 1.0).abs() < 1e-12);
    /// let (upper, _) = Scene::vertical_sun(0.0).ray([200.0, 0.0], [400.0, 200.0]).unwrap();
    /// assert!((upper[1] - 6.0 * 10_f64.to_radians().tan()).abs() < 1e-12 && upper[1] > HALF_SIDE);
    /// ```
    #[must_use]
    pub fn ray(&self, point: [f64; 2], size: [f64; 2]) -> Option<([f64; 2], [f64; 3])> {
        let shorter = size[0].min(size[1]);
        let scale = 2.0 * (0.5 * FIELD_OF_VIEW).to_radians().tan() / shorter;
        let (right, up) = (scale * (point[0] - 0.5 * size[0]), scale * (0.5 * size[1] - point[1]));
        let (sin, cos) = self.view.sin_cos();
        // forward (0, sin, -cos) + right (1, 0, 0) + up (0, cos, sin)
        let direction = [right, sin + up * cos, up * sin - cos];
        let goes_down = direction[2] < 0.0;
        if !goes_down {
            return None;
        }
        let [_, y, z] = self.to_camera().map(|component| CAMERA_DISTANCE * component);
        let steps = z / -direction[2];
        let length = (right * right + up * up + 1.0).sqrt();
        let at = [steps * direction[0], y + steps * direction[1]];
        Some((at, direction.map(|component| -component / length)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilted_view_meets_the_wing_where_the_camera_says() {
        let scene = Scene::vertical_sun(60_f64.to_radians());
        let (at, to_camera) = scene.ray([11.0, 70.0], [100.0, 80.0]).unwrap();
        let camera = scene.to_camera().map(|component| CAMERA_DISTANCE * component);
        let there = [camera[0] - at[0], camera[1] - at[1], camera[2]];
        let length = there.iter().map(|component| component * component).sum::<f64>().sqrt();
        for (found, expected) in to_camera.iter().zip(there) {
            assert!((found - expected / length).abs() < 1e-12);
        }
        assert!(at[0] < 0.0 && at[1] < 0.0, "left and below: {at:?}");
    }

    #[test]
    fn beyond_the_horizon_there_is_no_wing() {
        let scene = Scene::vertical_sun(85_f64.to_radians());
        assert!(scene.ray([50.0, 0.0], [100.0, 100.0]).is_none());
        assert!(scene.ray([50.0, 50.0], [100.0, 100.0]).is_some());
        for view in [FRAC_PI_2, f64::NAN] {
            assert!(Scene::vertical_sun(view).validate().is_err());
        }
    }
}
