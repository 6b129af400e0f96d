//! The outline of what a whisker swept along.
