//! The fixed words of the corridor's answers, the same in every file, message and binding.

use super::pose::Status;
use core::fmt;

impl Status {
    /// The word that files and messages use.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Localized => "localized",
            Self::Ambiguous => "ambiguous",
            Self::Inconsistent => "inconsistent",
            Self::NoContact => "no_contact",
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}
