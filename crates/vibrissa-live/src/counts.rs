//! What became of everything that arrived, counted.

/// Counts of one source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Bytes that arrived.
    pub bytes: u64,
    /// Lines that ended.
    pub lines: u64,
    /// Frames that were read.
    pub frames: u64,
    /// Lines that hold no frame: cut, garbled, or of something else.
    pub damaged: u64,
    /// Beginnings and ends of lines at a place where the stream broke off.
    pub torn: u64,
    /// Frames that are missing by their numbers, or by the time that passed.
    pub lost: u64,
    /// Frames that came again: dropped.
    pub repeated: u64,
    /// Frames that came after newer ones: dropped.
    pub late: u64,
    /// Times the device's count or clock began anew or jumped.
    pub resets: u64,
    /// Times a count or a stamp ran over and was carried on.
    pub wrapped: u64,
    /// Readings at the end of the sensor's range.
    pub saturated: u64,
    /// Frames whose readings are all zero.
    pub zeros: u64,
    /// Times the source went away.
    pub gone: u64,
    /// Frames for which no odometry or no other reading came in time: dropped.
    pub unjoined: u64,
    /// Frames with readings beyond the calibration's range: dropped.
    pub uncalibrated: u64,
}

impl Counts {
    /// Every count by name, in a fixed order.
    #[must_use]
    pub fn all(&self) -> [(&'static str, u64); 15] {
        [
            ("bytes", self.bytes),
            ("lines", self.lines),
            ("frames", self.frames),
            ("damaged", self.damaged),
            ("torn", self.torn),
            ("lost", self.lost),
            ("repeated", self.repeated),
            ("late", self.late),
            ("resets", self.resets),
            ("wrapped", self.wrapped),
            ("saturated", self.saturated),
            ("zeros", self.zeros),
            ("gone", self.gone),
            ("unjoined", self.unjoined),
            ("uncalibrated", self.uncalibrated),
        ]
    }

    /// Frames that were sent and did not become part of a row, as far as it is known.
    #[must_use]
    pub fn missing(&self) -> u64 {
        self.damaged + self.torn + self.lost + self.late + self.unjoined + self.uncalibrated
    }

    /// What was not in order, in words; empty where all was.
    #[must_use]
    pub fn words(&self) -> String {
        let told = self
            .all()
            .into_iter()
            .filter(|(name, count)| *count > 0 && !matches!(*name, "bytes" | "lines" | "frames" | "wrapped" | "zeros"));
        told.map(|(name, count)| format!("{count} {name}")).collect::<Vec<_>>().join(", ")
    }
}
