//! Programs with mistakes, in `ui`, each in a file named after its mistake.
