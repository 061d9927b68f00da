//! [`Format`]: which format a log is in, by how it begins; what cannot be read has a name too, and what to do instead.

use super::{python_can, words::Words};

/// Formats of logs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// Header with sequence,sent,received, then a row per packet.
    Csv,
    /// Lines of `candump -L`.
    Candump,
    /// The view of `candump -ta`, `-tz` or `-td`.
    CandumpView,
    /// Vector ASC.
    Asc,
    /// Vector BLF.
    Blf,
    /// PEAK TRC.
    Trc,
    /// Messages printed by python-can.
    PythonCanText,
    /// python-can's CSV.
    PythonCanCsv,
    /// pcap or pcapng.
    Pcap,
    /// JSON of irtt.
    Irtt,
    /// Raw output of owping.
    Owping,
    /// Output of ping.
    Ping,
    /// Output of fping.
    Fping,
}

impl Format {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv => "CSV table",
            Self::Candump => "candump -L",
            Self::CandumpView => "view of candump",
            Self::Asc => "Vector ASC",
            Self::Blf => "Vector BLF",
            Self::Trc => "PEAK TRC",
            Self::PythonCanText => "python-can text",
            Self::PythonCanCsv => "python-can CSV",
            Self::Pcap => "pcap or pcapng",
            Self::Irtt => "irtt JSON",
            Self::Owping => "owping -R",
            Self::Ping => "ping -D",
            Self::Fping => "fping -D",
        }
    }
}

const CONVERT: &str = "convert it with python-can: can_logconvert IN out.log";

/// The format of a log that begins with `head`, or why there is none to read it by.
pub(in super::super) fn recognised(head: &[u8]) -> Result<Format, String> {
    let refused = |name: &str, advice: &str| Err(format!("found {name}; {advice}"));
    if head.trim_ascii().is_empty() {
        return refused("nothing", "the log is empty");
    }
    if head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") {
        return refused("text in UTF-16", "save it in UTF-8 (PowerShell: Out-File -Encoding utf8)");
    }
    if is_capture(head) {
        return Ok(Format::Pcap);
    }
    match head {
        [b'L', b'O', b'G', b'G', ..] => return Ok(Format::Blf),
        [b'M', b'D', b'F', b' ', ..] | [b'U', b'n', b'F', b'i', b'n', b'M', b'F', ..] => {
            return refused("MDF (MF4)", CONVERT);
        }
        [0x89, b'M', b'C', b'A', b'P', ..] => {
            let advice = "its log and publish times say nothing of when a message was sent; let the receiving node write \
                          sequence,sent,received from the message's header stamp and the time of its arrival";
            return refused("MCAP (ROS 2)", advice);
        }
        [b'B', b'Z', b'h', ..] => {
            return refused("a file packed with bzip2", "unpack it with bunzip2; gzip and zstd are read");
        }
        [0xfd, b'7', b'z', b'X', b'Z', ..] => {
            return refused("a file packed with xz", "unpack it with unxz; gzip and zstd are read");
        }
        [b'P', b'K', 3, 4, ..] => return refused("a zip archive", "unpack it"),
        _ => {}
    }
    if head.starts_with(b"SQLite format 3\0") {
        let advice = "python-can's table of messages has no channel, so the ends cannot be told apart; log to a .log or .blf file";
        return refused("an SQLite database", advice);
    }
    if head.contains(&0) {
        return refused("a binary file of no known format", "docs/traces.md lists what is read");
    }
    let first = first_line(head);
    if let Some(format) = measured(head, first) {
        return format;
    }
    if first.starts_with(b"(") || first.starts_with(b"DROPCOUNT:") && has(head, b"#") {
        let is_log = lines(head).any(|line| {
            line.starts_with(b"(") && Words(line).nth(2).is_some_and(|word| word.contains(&b'#'))
        });
        let is_view = lines(head).any(|line| {
            line.starts_with(b"(")
                && is_length(Words(line.splitn(2, |byte| *byte == b')').nth(1).unwrap_or_default()))
        });
        return Ok(if is_view && !is_log { Format::CandumpView } else { Format::Candump });
    }
    if is_length(Words(first)) {
        let advice = "log again with candump -L, or with -ta for times";
        return refused("the view of candump without times (time stamps)", advice);
    }
    let words: Vec<&[u8]> = Words(first).take(2).collect();
    match words.as_slice() {
        [b"date", ..] | [b"base", b"hex" | b"dec"] => return Ok(Format::Asc),
        [b"Timestamp:", ..] => return Ok(Format::PythonCanText),
        _ => {}
    }
    if lines(head).take(40).any(|line| line.starts_with(b"base hex") || line.starts_with(b"base dec")) {
        return Ok(Format::Asc);
    }
    if first.starts_with(b";$FILEVERSION") || lines(head).take(40).any(|line| line.starts_with(b";---+--")) {
        return Ok(Format::Trc);
    }
    if first.starts_with(python_can::CSV_HEADER) {
        return Ok(Format::PythonCanCsv);
    }
    Ok(Format::Csv)
}

/// Output of a tool that measures a link by packets of its own.
fn measured(head: &[u8], first: &[u8]) -> Option<Result<Format, String>> {
    if first.starts_with(b"{") || first.starts_with(b"[{") {
        return Some(if has(head, b"\"irtt\"") || has(head, b"\"round_trips\"") {
            Ok(Format::Irtt)
        } else if has(head, b"\"sum_sent\"")
            || has(head, b"\"intervals\"")
            || has(head, b"\"test_start\"")
            || has(head, b"iperf")
        {
            Err("found JSON of iperf3, which has totals and nothing per packet; measure with irtt, or capture both ends with tcpdump".into())
        } else {
            Err("found JSON of no known tool; irtt's is read, see docs/traces.md".into())
        });
    }
    if first.starts_with(b"Connecting to host ") || has(first, b"iperf") {
        return Some(Err("found output of iperf, which has totals and nothing per packet; measure with irtt, or capture both ends with tcpdump".into()));
    }
    if has(head, b"sockperf") || has(head, b"txTime(sec)") {
        return Some(Err(
            "found a log of sockperf: its latency is half a round trip by one clock, and its rows are numbered without gaps where \
             packets were lost, so losses cannot be seen; measure with irtt, or capture both ends with tcpdump"
                .into(),
        ));
    }
    if first.starts_with(b"PING ") || has(head, b"icmp_seq=") {
        return Some(Ok(Format::Ping));
    }
    if first.starts_with(b"[") && has(first, b" : [") {
        return Some(Ok(Format::Fping));
    }
    // Number, send time, synchronised, error, arrival, synchronised, error, time to live.
    let words: Vec<&[u8]> = Words(first).collect();
    let is_number = |word: &&[u8]| word.iter().all(u8::is_ascii_digit);
    if words.len() == 8 && [0, 1, 2, 4, 5].iter().all(|&at| is_number(&words[at])) && words[1].len() == 20 {
        return Some(Ok(Format::Owping));
    }
    None
}

fn is_capture(head: &[u8]) -> bool {
    const PCAPNG: [u8; 4] = [0x0a, 0x0d, 0x0d, 0x0a];
    const PCAP: [[u8; 4]; 4] = [
        [0xd4, 0xc3, 0xb2, 0xa1],
        [0xa1, 0xb2, 0xc3, 0xd4],
        [0x4d, 0x3c, 0xb2, 0xa1],
        [0xa1, 0xb2, 0x3c, 0x4d],
    ];
    head.first_chunk().is_some_and(|magic| *magic == PCAPNG || PCAP.contains(magic))
}

/// Whether words are those of candump's view: interface, identifier, length in brackets.
fn is_length(mut words: Words<'_>) -> bool {
    let id =
        words.nth(1).is_some_and(|id| id.iter().all(u8::is_ascii_hexdigit) || matches!(id, b"RX" | b"TX"));
    id && words.any(|word| word.starts_with(b"["))
}

fn lines(head: &[u8]) -> impl Iterator<Item = &[u8]> {
    head.split(|byte| *byte == b'\n').map(|line| line.trim_ascii())
}

fn first_line(head: &[u8]) -> &[u8] {
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    lines(head).find(|line| !line.is_empty()).unwrap_or_default()
}

fn has(text: &[u8], part: &[u8]) -> bool {
    memchr::memmem::find(text, part).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logs_are_recognised_by_how_they_begin() {
        for (head, format) in [
            ("(1.5) can0 123#00\n", Format::Candump),
            (" (1.5)  can0  123   [1]  00\n", Format::CandumpView),
            ("DROPCOUNT: dropped 3\n(1.5) can0 123#00\n", Format::Candump),
            ("date Tue Nov 14 22:13:20 2023\nbase hex  timestamps absolute\n", Format::Asc),
            (";$FILEVERSION=2.1\n", Format::Trc),
            ("Timestamp: 1.5 ID: 1", Format::PythonCanText),
            ("timestamp,arbitration_id,extended,remote,error,dlc,data\n", Format::PythonCanCsv),
            ("LOGG", Format::Blf),
            ("{\n \"version\": {\n  \"irtt\": \"0.9.0\"", Format::Irtt),
            ("PING 127.0.0.1", Format::Ping),
            ("[1795812814.55687] 127.0.0.1 : [0], 64 bytes", Format::Fping),
            ("0 16788979058578197944 1 6.1e-05 16788979058594647669 1 7.3e-05 64\n", Format::Owping),
            ("sequence,sent,received\n", Format::Csv),
        ] {
            assert_eq!(recognised(head.as_bytes()), Ok(format), "{head}");
        }
    }

    #[test]
    fn what_cannot_be_read_is_named_with_what_to_do() {
        for (head, words) in [
            ("MDF     4.10", "can_logconvert"),
            ("SQLite format 3\0", "no channel"),
            ("\u{0}\u{1}", "binary file"),
            ("{\"start\": {}, \"intervals\": []}", "iperf3"),
            ("{}", "JSON of no known tool"),
            ("sockperf: [Total Run]", "losses cannot be seen"),
            ("  can0  123   [1]  00\n", "candump -L"),
            ("PK\u{3}\u{4}", "zip"),
            (" \n\n", "empty"),
        ] {
            let problem = recognised(head.as_bytes()).expect_err(head);
            assert!(problem.contains(words), "{head}: {problem}");
        }
        assert!(recognised(b"\xff\xfes\0e\0").is_err_and(|problem| problem.contains("UTF-8")));
    }
}
