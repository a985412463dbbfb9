//! Methods that a variational step is compared with, one a file, on the generated first-order form.
