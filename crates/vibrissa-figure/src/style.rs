//! Colours and type, once for all figures.
//!
//! The hues are those of Okabe and Ito, which stay apart for every common kind of colour blindness; every role differs
//! in shape or weight as well.

/// The stylesheet of every figure.
pub(crate) const SHEET: &str = "\
text { font-family: system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', 'Noto Sans', 'DejaVu Sans', sans-serif; font-size: 13px; fill: #1a1a1a; }
.title { font-size: 19px; font-weight: 600; }
.caption { font-size: 14px; fill: #333; }
.heading { font-weight: 600; }
.small { font-size: 11.5px; fill: #555; }
.end { text-anchor: end; }
.middle { text-anchor: middle; }
.page { fill: #fff; }
.panel { fill: none; stroke: #999; stroke-width: 1; }
.tick, .bar { stroke: #555; stroke-width: 1; fill: none; }
.bar { stroke: #1a1a1a; stroke-width: 2; }
.solid { fill: #e3e3e0; }
.free { fill: #fff; }
.arena { fill: #fff; stroke: #222; stroke-width: 1.8; stroke-linejoin: round; }
.obstacle { fill: #c9c9c4; stroke: #222; stroke-width: 1.8; stroke-linejoin: round; }
.wall { fill: none; stroke: #222; stroke-width: 2.6; stroke-linecap: round; stroke-linejoin: round; }
.map-band { fill: #56b4e9; fill-opacity: 0.45; stroke: none; }
.unknown-gap { fill: none; stroke: #fff; stroke-width: 3.4; }
.unknown { fill: none; stroke: #777; stroke-width: 1.6; stroke-dasharray: 4 4; }
.candidate { fill: none; stroke: #e69f00; stroke-opacity: 0.4; stroke-width: 2.6; stroke-linecap: round; }
.candidate-tick { fill: none; stroke: #e69f00; stroke-opacity: 0.4; stroke-width: 0.9; }
.earlier { fill: none; stroke: #e69f00; stroke-width: 5; stroke-linecap: round; }
.earlier-tick { fill: none; stroke: #e69f00; stroke-width: 1.6; }
.survivor { fill: none; stroke: #d55e00; stroke-width: 4; stroke-linecap: round; }
.survivor-tick { fill: none; stroke: #d55e00; stroke-width: 1.3; }
.survivor-box { fill: #d55e00; fill-opacity: 0.3; stroke: #d55e00; stroke-width: 0.6; }
.truth { fill: none; stroke: #8fd3bd; stroke-width: 6; stroke-linecap: round; stroke-linejoin: round; }
.truth-mark { fill: none; stroke: #00795a; stroke-width: 1.8; }
.path { fill: none; stroke: #0072b2; stroke-width: 1.8; stroke-linejoin: round; }
.path-unsure { fill: none; stroke: #777; stroke-width: 1.4; stroke-dasharray: 5 4; stroke-linejoin: round; }
.motion { fill: none; stroke: #0072b2; stroke-width: 1.8; stroke-dasharray: 3 3; stroke-linejoin: round; }
.motion-end { fill: none; stroke: #0072b2; stroke-width: 5; stroke-linecap: round; }
.motion-end-tick { fill: none; stroke: #0072b2; stroke-width: 1.3; }
.decision { fill: none; stroke: #00795a; stroke-width: 6; stroke-linecap: round; }
.decision-tick { fill: none; stroke: #00795a; stroke-width: 1.6; }
.whisker { fill: none; stroke: #a64d85; stroke-opacity: 0.55; stroke-width: 0.9; stroke-linecap: round; stroke-linejoin: round; }
.whisker-last { fill: none; stroke: #a64d85; stroke-width: 2.2; stroke-linecap: round; stroke-linejoin: round; }
.tip-contact { fill: none; stroke: #d55e00; stroke-width: 3.4; stroke-linecap: round; }
.sliding-side { fill: none; stroke: #009e73; stroke-width: 3.4; stroke-linecap: round; }
.side-contact { fill: none; stroke: #0072b2; stroke-width: 5; stroke-linecap: round; }
.closed-form { fill: none; stroke: #999; stroke-width: 2.6; stroke-linecap: round; }
.band { fill: #e69f00; fill-opacity: 0.35; stroke: none; }
.edge { fill: none; stroke: #222; stroke-width: 1.8; stroke-linejoin: round; }
.outline { fill: none; stroke: #d55e00; stroke-width: 1.6; stroke-linejoin: round; }
.robot { fill: #0072b2; fill-opacity: 0.1; stroke: #0072b2; stroke-width: 1; }
.estimate { fill: #0072b2; stroke: #fff; stroke-width: 1.2; }
.estimate-line { fill: none; stroke: #0072b2; stroke-width: 2.4; stroke-linecap: round; }
.start { fill: #fff; stroke: #0072b2; stroke-width: 1.8; }
.ridge { fill: none; stroke: #0072b2; stroke-width: 2.6; stroke-opacity: 0.55; stroke-linecap: round; stroke-linejoin: round; }
.extent { fill: #0072b2; fill-opacity: 0.08; stroke: #0072b2; stroke-width: 1.1; stroke-dasharray: 4 3; }
.fan { fill: #0072b2; fill-opacity: 0.25; stroke: none; }
.badge { fill: #fff; stroke: #0072b2; stroke-width: 1.4; }
.badge-line { stroke: #0072b2; stroke-width: 1; fill: none; }
.badge-text { font-size: 11px; font-weight: 600; fill: #00507d; text-anchor: middle; }
.series { fill: none; stroke-width: 1.5; stroke-linejoin: round; }
.reading { fill: none; stroke-opacity: 0.45; stroke-width: 2.2; stroke-linecap: round; }
.hue0 { stroke: #0072b2; } .hue1 { stroke: #d55e00; } .hue2 { stroke: #00795a; } .hue3 { stroke: #a64d85; }
.hue4 { stroke: #b07a00; } .hue5 { stroke: #3f8fbf; } .hue6 { stroke: #1a1a1a; } .hue7 { stroke: #7a7a00; }
.series.hue4, .series.hue5, .series.hue6, .series.hue7 { stroke-dasharray: 6 3; }
.touch { fill: none; stroke: #e69f00; stroke-opacity: 0.8; stroke-width: 3.4; stroke-linecap: round; }
.grid { stroke: #ddd; stroke-width: 1; fill: none; }
.undeflected { fill: none; stroke: #777; stroke-width: 1.2; stroke-dasharray: 5 4; }
.shape { fill: none; stroke: #d55e00; stroke-opacity: 0.75; stroke-width: 1.1; stroke-linejoin: round; }
.force { fill: none; stroke: #222; stroke-width: 1.5; stroke-linecap: round; stroke-linejoin: round; }
.contact-point { fill: none; stroke: #222; stroke-width: 7; stroke-linecap: round; }
.base { fill: #222; stroke: none; }
.contact-a { fill: none; stroke: #009e73; stroke-width: 3.2; stroke-linecap: round; stroke-linejoin: round; }
.contact-b { fill: none; stroke: #0072b2; stroke-width: 3.2; stroke-dasharray: 9 5; stroke-linejoin: round; }
.contact-c { fill: none; stroke: #a64d85; stroke-width: 3.2; stroke-dasharray: 2 4; stroke-linejoin: round; }
.contact-d { fill: none; stroke: #222; stroke-width: 2.4; stroke-dasharray: 9 4 2 4; stroke-linejoin: round; }
.region { fill: #009e73; fill-opacity: 0.55; stroke: #009e73; stroke-width: 0.6; }
.shared { fill: #111111; stroke: #111111; stroke-width: 3.0; stroke-linejoin: round; }
.meeting { fill: #fff; fill-opacity: 0.6; stroke: #222; stroke-width: 2; }
.strip { fill: #2484bd; fill-opacity: 0.85; stroke: none; }
.strip-3 { fill: #56b4e9; fill-opacity: 0.75; stroke: none; }
.strip-2 { fill: #56b4e9; fill-opacity: 0.45; stroke: none; }
.strip-1 { fill: #56b4e9; fill-opacity: 0.2; stroke: none; }
.slice { fill: #d55e00; fill-opacity: 0.8; stroke: none; }
.zoomed { fill: none; stroke: #555; stroke-width: 1; stroke-dasharray: 2 2; }
";
