//! Tables of states, of paths and of histograms: names as in the Lagrangian, and the same bits in
//! every format.

mod names;
mod written;
