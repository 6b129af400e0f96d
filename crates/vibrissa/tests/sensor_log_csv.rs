//! Logs: column order, several whiskers, encodings, streams.

use std::f64::consts::PI;
use std::io::Read;
use vibrissa::flow::sensor_log::Quantity;

#[test]
fn any_order_and_several_whiskers() {
    let text =
        "right.moment, theta,y,left.bx,heading,x,left.moment,t\n-3e-4,0.5,2,7e-5,-1,1,4E-4,0.0\n0,7.0,2,0,-1,1,0,1\n";
    let log = vibrissa::io::log::from_csv(text, "log.csv").unwrap();
    let columns: Vec<String> = log.channels.iter().map(|c| c.column()).collect();
    assert_eq!(columns, ["right.moment", "left.bx", "left.moment"]);
    assert_eq!(log.channels[1].quantity, Quantity::FluxX);
    let row = &log.rows[0];
    assert_eq!((row.t, row.odom_from_robot.x, row.odom_from_robot.y, row.odom_from_robot.theta), (0.0, 1.0, 2.0, 0.5));
    assert_eq!(row.readings, [-3e-4, 7e-5, 4e-4]);
    assert_eq!(row.heading, Some(-1.0));
    assert!((log.rows[1].odom_from_robot.theta - (7.0 - 2.0 * PI)).abs() < 1e-15);
    assert_eq!((log.moment_channel("left").unwrap(), log.moment_channel("right").unwrap()), (2, 0));
    let log = vibrissa::io::log::from_csv("t,x,y,theta,moment\n0,0,0,0,1\n", "log.csv").unwrap();
    assert_eq!((log.moment_channel("w0").unwrap(), log.rows[0].heading), (0, None));
}

#[test]
fn foreign_line_ends_and_marks() {
    let plain = "t,x,y,theta,moment\n0,1,2,3,4e-3\n1,1,2,3,5e-3\n";
    let expected = vibrissa::io::log::from_csv(plain, "a").unwrap();
    for text in [
        format!("\u{feff}{plain}"),
        plain.replace('\n', "\r\n"),
        format!("{plain}\n\n  \n"),
        plain.replace(',', " , "),
        plain.replace("t,x", "\"t\",x"),
    ] {
        assert_eq!(vibrissa::io::log::from_csv(&text, "a").unwrap(), expected, "{text:?}");
    }
    // Whether the last number is whole nobody knows without the line's end.
    let cut = vibrissa::io::log::from_csv(plain.trim_end(), "a").unwrap();
    assert_eq!((cut.rows.as_slice(), cut.warnings.len()), (&expected.rows[..1], 1));
}

/// A source that gives one byte at a time.
struct Trickle<'a>(&'a [u8]);

impl Read for Trickle<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = buffer.len().min(self.0.len()).min(1);
        buffer[..count].copy_from_slice(&self.0[..count]);
        self.0 = &self.0[count..];
        Ok(count)
    }
}

#[test]
fn a_log_cut_anywhere_never_gains_rows_or_panics() {
    let text = "t,x,y,theta,moment\n0.000,0.0005,-0.1,0.25,1.5e-03\n0.003,0.0010,-0.1,0.25,1.75e-03\n";
    let whole = vibrissa::io::log::from_csv(text, "log.csv").unwrap();
    for cut in 0..text.len() {
        let Ok(log) = vibrissa::io::log::from_reader(Trickle(&text.as_bytes()[..cut]), "log.csv") else { continue };
        assert_eq!(log.rows[0].t.to_bits(), whole.rows[0].t.to_bits());
        assert!(log.rows.len() <= 2);
        let complete = text[..cut].ends_with('\n') || log.rows.len() == 2;
        assert!(complete || log.rows.len() == 1);
    }
    let bad = b"t,x,y,theta,moment\n0,0,0,0,\xff\xfe\n1,0,0,0,0\n";
    assert_eq!(vibrissa::io::log::from_reader(&bad[..], "log.csv").unwrap_err().line(), Some(2));
}

#[test]
fn files_that_are_no_logs_are_refused_before_they_fill_the_memory() {
    // A gigabyte without a line end, made as it is read.
    let endless = std::io::repeat(b'7').take(1 << 30);
    let begin = "t,x,y,theta,moment\n".as_bytes();
    let error = vibrissa::io::log::from_reader(begin.chain(endless), "log.csv").unwrap_err();
    assert!(error.to_string().contains("line is too long: more than 1048576 bytes"), "{error}");
}
