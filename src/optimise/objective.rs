//! What is minimised: residuals and their derivatives.

use crate::optimise::bounds::Bounds;
use crate::optimise::difference::central_jacobian;
use crate::optimise::products::Products;
use argmin::core::{Error, Jacobian, Operator};
use nalgebra::{DMatrix, DVector};

/// Residuals `r(p)` of a least-squares problem.
///
/// A residual that is not finite marks a point as forbidden: the solver turns back from it.
pub trait LeastSquares {
    /// Residuals at `parameters`.
    ///
    /// # Shape
    /// `parameters: [n]`, result `[m]`, the same `m` at every point.
    fn residuals(&self, parameters: &DVector<f64>) -> DVector<f64>;

    /// The allowed box.
    fn bounds(&self) -> &Bounds;

    /// A change of each parameter that matters, above 0: the unit of difference steps and of the rank test.
    ///
    /// # Shape
    /// `[n]`
    fn scales(&self) -> &DVector<f64>;

    /// Derivatives `J_ij = d r_i / d p_j`; central differences unless a problem knows better.
    ///
    /// # Shape
    /// `[m, n]`
    fn jacobian(&self, parameters: &DVector<f64>) -> DMatrix<f64> {
        central_jacobian(|p| self.residuals(p), parameters, self.scales(), self.bounds())
    }

    /// `J' J` and `J' r` at `parameters`, where the residuals are `residuals`; from the Jacobian unless a problem knows
    /// better.
    fn products(&self, parameters: &DVector<f64>, residuals: &DVector<f64>) -> Products {
        Products::new(&self.jacobian(parameters), residuals)
    }
}

/// What a solver asks of a problem beside residuals and Jacobian.
pub trait Linearise {
    /// `J' J` and `J' r`, as [`LeastSquares::products`].
    fn products(&self, parameters: &DVector<f64>, residuals: &DVector<f64>) -> Products;
}

/// A [`LeastSquares`] as argmin sees it.
#[derive(Debug)]
pub struct ArgminProblem<'a, L: ?Sized>(pub &'a L);

impl<L: LeastSquares + ?Sized> Operator for ArgminProblem<'_, L> {
    type Param = DVector<f64>;
    type Output = DVector<f64>;
    fn apply(&self, parameters: &DVector<f64>) -> Result<DVector<f64>, Error> {
        Ok(self.0.residuals(parameters))
    }
}

impl<L: LeastSquares + ?Sized> Jacobian for ArgminProblem<'_, L> {
    type Param = DVector<f64>;
    type Jacobian = DMatrix<f64>;
    fn jacobian(&self, parameters: &DVector<f64>) -> Result<DMatrix<f64>, Error> {
        Ok(self.0.jacobian(parameters))
    }
}

impl<L: LeastSquares + ?Sized> Linearise for ArgminProblem<'_, L> {
    fn products(&self, parameters: &DVector<f64>, residuals: &DVector<f64>) -> Products {
        self.0.products(parameters, residuals)
    }
}
