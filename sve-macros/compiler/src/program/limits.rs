//! All sizes beyond which code is not printed, or is printed in another way.

/// Largest sizes of a loop over the lanes. The values of a longer loop fit neither the registers
/// nor the first-level cache, and the compiler makes no vectors of it.
pub(crate) mod in_lanes {
    /// Instructions of all loops of a step, of its linearisation, of an energy or of a test of
    /// masses.
    pub(crate) const INSTRUCTIONS: usize = 1500;
    /// Values that are kept between loops.
    pub(crate) const KEPT: usize = 96;
    /// Unknowns of a block, of a linearised step, whose inverse is dense, and of a block of the
    /// mass matrix.
    pub(crate) const UNKNOWNS: usize = 6;
    /// Unknowns of a block with multipliers of constraints: most entries of its Jacobian are zero,
    /// and not computed.
    pub(crate) const CONSTRAINED: usize = 16;
    /// Unknowns up to which a matrix is solved by a formula.
    pub(crate) const BY_FORMULA: usize = 2;
    /// Instructions of all stages of a step of an explicit method. Of longer loops the compiler
    /// makes no vectors: a step of the double pendulum by Heun's method, of 330, takes longer than
    /// a single step.
    pub(crate) const EULER: usize = 120;
}

/// Instructions of the increment of Euler's method, and of one that becomes part of each stage of a
/// method.
pub(crate) const EULER: usize = 4000;
pub(crate) const EULER_INLINED: usize = 1500;

/// Work of a call of a function, and of a division or a root, in additions.
pub(crate) const CALL: usize = 30;
pub(crate) const DIVISION: usize = 4;

/// Smallest number of rows and columns of a matrix that may be written by its entries, and the
/// number of tokens of an assignment to an entry in units of the tokens of a zero.
pub(crate) const SPARSE_SIZE: usize = 7;
pub(crate) const SPARSE_ENTRY: usize = 4;

/// Operations of a statement, beyond which an operand has a statement of its own.
pub(crate) const OPERATIONS_OF_STATEMENT: usize = 6;

/// Largest number of `let` statements in a block that is not cut, and smallest number in an inner
/// block. Smaller inner blocks have to return more of their values.
pub(crate) const LETS: usize = 500;
pub(crate) const LETS_OF_PART: usize = 250;
