//! Slaves with a fault in MS1 or MS2.

use super::*;

pub static SLAVES: &[FaultySlave] = &[
    slave(
        "ms1.closed",
        "opens MS1 outside data exchange",
        Answers(|slave, request, answer| if request.dsap == MS1 && is_waiting(slave) { sc() } else { answer }),
    ),
    slave(
        "ms1.poll",
        "refuses a poll of MS1 without a response",
        Answers(|_, request, answer| {
            if request.dsap == MS1 && request.du.is_empty() && answer == sc() { status(request, RR) } else { answer }
        }),
    ),
    slave(
        "ms1.foreign",
        "opens MS1 to any master",
        Answers(|_, request, answer| if request.dsap == MS1 && request.sa != MASTER { sc() } else { answer }),
    ),
    slave(
        "ms1.refusal",
        "returns an empty record for a slot that it does not have",
        ChangesAnswer(|request, answer| {
            if request.dsap == MS1 && answer.du.first() == Some(&0xDE) {
                answer.du = vec![0x5E, 254, 1, 0];
            }
        }),
    ),
    slave(
        "ms1.low-priority",
        "sends responses of MS1 with high priority",
        ChangesAnswer(|request, answer| {
            if request.dsap == MS1 && answer.fc == 8 {
                answer.fc = 0x0A;
            }
        }),
    ),
    slave(
        "ms1.error-decode",
        "sends a reserved Error_Decode over MS1",
        ChangesAnswer(|request, answer| {
            if request.dsap == MS1 && answer.du.first() == Some(&0xDE) {
                answer.du[1] = 0x81;
            }
        }),
    ),
    slave(
        "ms2.manager",
        "names an access point above 48",
        ChangesAnswer(|request, answer| {
            if request.dsap == MANAGER && answer.du.len() > 1 {
                answer.du[1] = 54;
            }
        }),
    ),
    slave(
        "ms2.abort-closes",
        "ignores Abort",
        Reacts(|| {
            Box::new(|line, octets| match Frame::parse(octets) {
                Some(request) if request.is_connection() && request.du.first() == Some(&0x58) => sc(),
                _ => line.send(octets),
            })
        }),
    ),
    slave(
        "ms2.initiate",
        "refuses Initiate on the access point that it named",
        ChangesAnswer(|request, answer| {
            if request.is_connection() && answer.du.first() == Some(&0x57) {
                answer.du = vec![0xD7, 0x80, 0xA9, 0];
            }
        }),
    ),
    slave(
        "ms2.abort",
        "answers Abort with RR",
        Answers(|_, request, answer| {
            if request.is_connection() && request.du.first() == Some(&0x58) && answer == sc() {
                status(request, RR)
            } else {
                answer
            }
        }),
    ),
    slave(
        "ms2.record-length",
        "reports that its longest record has no octets",
        ChangesAnswer(|request, answer| {
            if request.is_connection() && answer.du.first() == Some(&0x57) {
                answer.du[1] = 0;
            }
        }),
    ),
    slave(
        "ms2.poll",
        "refuses a poll of MS2 without a response",
        Answers(|_, request, answer| {
            if request.is_connection() && request.du.is_empty() && answer == sc() {
                status(request, RR)
            } else {
                answer
            }
        }),
    ),
    slave(
        "ms2.idle",
        "answers Idle with another octet",
        ChangesAnswer(|request, answer| {
            if request.is_connection() && answer.du == [0x48] {
                answer.du[0] = 0x49;
            }
        }),
    ),
    slave(
        "ms2.low-priority",
        "sends responses of MS2 with high priority",
        ChangesAnswer(|request, answer| {
            if request.is_connection() && answer.fc == 8 {
                answer.fc = 0x0A;
            }
        }),
    ),
    slave("ms2.repeated-poll", "executes a repeated poll", Counts(Counting::PollsAnew)),
    slave(
        "ms2.undisturbed",
        "drops a response when another master sends a request",
        Reacts(|| {
            let mut connection = None;
            Box::new(move |line, octets| {
                let Some(request) = Frame::parse(octets) else { return line.send(octets) };
                if request.is_connection() {
                    connection = Some(Frame { du: Vec::new(), ..request });
                } else if let Some(poll) = connection.as_ref().filter(|_| request.sa != MASTER) {
                    line.send(&as_first(poll));
                }
                line.send(octets)
            })
        }),
    ),
    slave(
        "ms2.foreign",
        "opens a connection to any master",
        Answers(|_, request, answer| if request.is_connection() && request.sa != MASTER { sc() } else { answer }),
    ),
    slave(
        "ms2.foreign-access-point",
        "does not look at the source access point of MS2",
        ChangesRequest(|request| {
            if request.is_connection() {
                request.ssap = Some(50);
            }
        }),
    ),
    slave(
        "ms2.refusal",
        "returns an empty record over MS2 for a slot that it does not have",
        ChangesAnswer(|request, answer| {
            if request.is_connection() && answer.du.first() == Some(&0xDE) {
                answer.du = vec![0x5E, 254, 1, 0];
            }
        }),
    ),
    slave(
        "ms2.error-decode",
        "sends a reserved Error_Decode over MS2",
        ChangesAnswer(|request, answer| {
            if request.is_connection() && answer.du.first() == Some(&0xDE) {
                answer.du[1] = 0x81;
            }
        }),
    ),
    slave(
        "ms2.error-class",
        "sends an error of resources for a slot that it does not have",
        ChangesAnswer(|request, answer| {
            if request.is_connection() && answer.du.first() == Some(&0xDE) {
                answer.du[2] = 0xC2;
            }
        }),
    ),
    slave(
        "ms2.unknown-function",
        "answers an unknown function with Idle",
        ChangesAnswer(|request, answer| {
            if request.is_connection() && answer.du.first() == Some(&0x58) {
                answer.du = vec![0x48];
            }
        }),
    ),
    slave(
        "ms2.abort-ends",
        "answers polls after its own Abort",
        Reacts(|| {
            let mut aborted = None;
            Box::new(move |line, octets| {
                let received = line.send(octets);
                let Some(request) = Frame::parse(octets) else { return received };
                if request.dsap == MANAGER {
                    aborted = None;
                }
                let answer = Frame::parse_answer(&received);
                if request.is_connection() && answer.is_some_and(|answer| answer.du.first() == Some(&0x58)) {
                    aborted = request.dsap;
                }
                if request.is_connection() && request.dsap == aborted && is_rs(&received) { sc() } else { received }
            })
        }),
    ),
    slave(
        "ms2.exchange",
        "leaves data exchange with Initiate",
        Reacts(|| ends_exchange(|request| request.dsap == MANAGER)),
    ),
];
