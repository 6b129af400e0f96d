//! What a reader mended, counted.

/// How often each kind of repair was made; see [`Repairs::words`] for people.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Lines that hold no reading: banners, errors, garbage.
    pub lines_dropped: usize,
    /// A last line that was cut short (also in `lines_dropped`).
    pub last_line_cut: usize,
    /// Times a count ran over the end of its 16 bits and was carried on.
    pub unwrapped: usize,
    /// Rows whose host stamp was replaced by the evenly spaced time that fits all stamps.
    pub stamps_smoothed: usize,
    /// Rows whose time was made from the nominal rate, because the file holds none.
    pub stamps_made: usize,
    /// Rows that were out of order in time, or the second of one time: dropped.
    pub out_of_order: usize,
    /// Readings at the end of the sensor's range.
    pub saturated: usize,
    /// Rows from which a reference sensor's reading was subtracted.
    pub reference_subtracted: usize,
    /// Times the order of two interleaved sensors was found again after a lost line.
    pub order_restored: usize,
    /// Rows for which the odometry was interpolated between two messages.
    pub interpolated: usize,
}

impl Repairs {
    /// Every count by name, in a fixed order, for JSON.
    #[must_use]
    pub fn counts(&self) -> [(&'static str, usize); 10] {
        [
            ("lines_dropped", self.lines_dropped),
            ("last_line_cut", self.last_line_cut),
            ("unwrapped", self.unwrapped),
            ("stamps_smoothed", self.stamps_smoothed),
            ("stamps_made", self.stamps_made),
            ("out_of_order", self.out_of_order),
            ("saturated", self.saturated),
            ("reference_subtracted", self.reference_subtracted),
            ("order_restored", self.order_restored),
            ("interpolated", self.interpolated),
        ]
    }

    /// One line of words for each kind of repair that was made; empty when the file was in order.
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        let meanings = [
            "lines without a reading, dropped",
            "last line, cut short",
            "16-bit counts that wrapped, carried on",
            "host stamps, replaced by evenly spaced times",
            "times made from the nominal rate",
            "rows out of order in time, dropped",
            "readings at the end of the sensor's range",
            "rows with the reference sensor subtracted",
            "order of the two sensors, found again",
            "rows with odometry interpolated between messages",
        ];
        let made = self.counts().into_iter().zip(meanings).filter(|((_, count), _)| *count > 0);
        made.map(|((_, count), meaning)| format!("{meaning}: {count}")).collect()
    }

    /// The repairs of two files together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            lines_dropped: self.lines_dropped + other.lines_dropped,
            last_line_cut: self.last_line_cut + other.last_line_cut,
            unwrapped: self.unwrapped + other.unwrapped,
            stamps_smoothed: self.stamps_smoothed + other.stamps_smoothed,
            stamps_made: self.stamps_made + other.stamps_made,
            out_of_order: self.out_of_order + other.out_of_order,
            saturated: self.saturated + other.saturated,
            reference_subtracted: self.reference_subtracted + other.reference_subtracted,
            order_restored: self.order_restored + other.order_restored,
            interpolated: self.interpolated + other.interpolated,
        }
    }
}

impl Repairs {
    /// Counts a line that holds no reading; the last line of a file without a line end was cut.
    pub(super) fn drop_line(&mut self, line: &super::lines::Line<'_>) {
        self.lines_dropped += 1;
        self.last_line_cut += usize::from(!line.ended);
    }
}
