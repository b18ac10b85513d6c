use super::{CHUNK, Framing, Head, Heads, MAX_HEAD, Refusal, Reuse};
use crate::auth::connections::Permits;
use crate::server::{Connections, Limits};
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::{Method, Uri};
use fastrand::Rng;
use std::net::{IpAddr, Ipv4Addr};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};
use tokio::task::yield_now;

/// Longer than any test: no limit of time decides.
const NEVER: Duration = Duration::from_secs(86_400);

/// Ends a connection that the server has not ended before.
const LAST: &[u8] = b"GET /last HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";

/// What a server has done with the octets of a connection, until it ended the connection.
#[derive(Debug, Default, PartialEq, Eq)]
struct Outcome {
    /// Method, path and body of each request that was executed.
    executed: Vec<String>,
    /// The status of each answer.
    answered: Vec<String>,
}

impl Outcome {
    fn new(executed: &[&str], answered: &[&str]) -> Self {
        let owned = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect();
        Self { executed: owned(executed), answered: owned(answered) }
    }
}

type Executed = Arc<Mutex<Vec<String>>>;

async fn execute(State(executed): State<Executed>, method: Method, uri: Uri, body: Bytes) {
    executed.lock().unwrap().push(format!("{method} {uri} {}", body.escape_ascii()).trim_end().to_owned());
}

/// Sends each piece when the server has taken the one before, and returns the answers.
async fn exchange<'a>(pieces: impl Iterator<Item = &'a [u8]>) -> (Vec<String>, String) {
    let executed = Executed::default();
    let connections = Connections {
        router: Router::new().fallback(execute).with_state(Arc::clone(&executed)),
        keys: None,
        limits: Limits { head: NEVER, stalled: NEVER, ..Limits::default() },
        observer: None,
    };
    let (mut client, server) = duplex(1 << 20);
    let peer = IpAddr::from(Ipv4Addr::LOCALHOST);
    let (permit, _evicted) = Permits::new(1).take(peer).unwrap();
    let served = tokio::spawn(async move { connections.answer(server, peer, permit).await });
    for piece in pieces {
        // The server may have ended the connection.
        if client.write_all(piece).await.is_err() {
            break;
        }
        yield_now().await;
    }
    let mut answers = String::new();
    client.read_to_string(&mut answers).await.unwrap();
    drop(client);
    served.await.unwrap();
    let executed = executed.lock().unwrap().clone();
    (executed, answers)
}

async fn outcome<'a>(pieces: impl Iterator<Item = &'a [u8]>) -> Outcome {
    let (executed, answers) = exchange(pieces).await;
    let status = |answer: &str| answer.get(..3).unwrap_or_default().to_owned();
    Outcome { executed, answered: answers.split("HTTP/1.1 ").skip(1).map(status).collect() }
}

/// Sends the octets at once, and again octet by octet: the outcome must be the same.
async fn outcome_of(octets: &[u8]) -> Outcome {
    let at_once = outcome(std::iter::once(octets)).await;
    assert_eq!(outcome(octets.chunks(1)).await, at_once, "{}", octets.escape_ascii());
    at_once
}

/// A head of this length.
fn head(length: usize) -> Vec<u8> {
    let (begin, end) = ("GET /long HTTP/1.1\r\nHost: x\r\nA: ", "\r\n\r\n");
    format!("{begin}{}{end}", "a".repeat(length - begin.len() - end.len())).into_bytes()
}

#[tokio::test]
async fn a_head_of_32768_octets_is_answered() {
    assert_eq!(MAX_HEAD, 32_768);
    let octets = [&head(32_768), LAST].concat();
    assert_eq!(outcome_of(&octets).await, Outcome::new(&["GET /long", "GET /last"], &["200", "200"]));
}

#[tokio::test]
async fn a_head_of_32769_octets_gets_431_and_no_further_request_is_executed() {
    for octets in [head(32_769), head(100_000)] {
        let octets = [b"GET /first HTTP/1.1\r\n\r\n", octets.as_slice(), LAST].concat();
        assert_eq!(outcome_of(&octets).await, Outcome::new(&["GET /first"], &["200", "431"]));
    }
    // The end of the head is not awaited.
    assert_eq!(outcome_of(&head(40_000)[..32_769]).await, Outcome::new(&[], &["431"]));
}

#[test]
fn empty_lines_before_the_request_line_count_in_the_length_of_a_head() {
    let octets = b"\r\n\r\nGET / HTTP/1.1\r\n\r\nX";
    assert_eq!(Head::default().check(octets), Some(Ok(octets.len() - 1)));
    let endless = b"\r\n".repeat(MAX_HEAD);
    assert_eq!(Head::default().check(&endless[..MAX_HEAD]), None);
    assert_eq!(Head::default().check(&endless), Some(Err(Refusal::TooLong)));
}

#[tokio::test]
async fn a_line_of_a_head_that_ends_with_lf_alone_gets_400_and_no_further_request_is_executed() {
    let heads: [&[u8]; 8] = [
        b"\nGET / HTTP/1.1\r\nHost: x\r\nA: b\r\n\r\n",
        b"\r\n\nGET / HTTP/1.1\r\nHost: x\r\nA: b\r\n\r\n",
        b"GET / HTTP/1.1\nHost: x\r\nA: b\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: x\nA: b\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: x\r\nA: b\n\r\n",
        b"GET / HTTP/1.1\r\nHost: x\r\nA: b\r\n\n",
        b"GET / HTTP/1.1\nHost: x\nA: b\n\n",
        b"GET / HTTP/1.1\r\nHost: x\r\nA: b\nContent-Length: 1000\r\n\r\n",
    ];
    for head in heads {
        let octets = [b"GET /first HTTP/1.1\r\n\r\n", head, LAST].concat();
        let expected = Outcome::new(&["GET /first"], &["200", "400"]);
        assert_eq!(outcome_of(&octets).await, expected, "{}", head.escape_ascii());
    }
    let (_, answer) = exchange(std::iter::once(heads[2])).await;
    assert!(answer.contains("expected CR LF at the end of each line"), "{answer}");
    assert!(
        answer.contains("\r\nconnection: close\r\n") && answer.contains("\r\nx-frame-options: DENY\r\n"),
        "{answer}"
    );
}

#[tokio::test]
async fn a_continued_line_and_a_cr_alone_get_400_and_no_further_request_is_executed() {
    for head in [
        "GET / HTTP/1.1\r\nA: b\r\n c\r\n\r\n",
        "GET / HTTP/1.1\r\nA: b\r\n\tc\r\n\r\n",
        "GET / HTTP/1.1\r\n A: b\r\n\r\n",
        "GET / HTTP/1.1\r\nA: b\rc\r\n\r\n",
        "GET / HTTP/1.1\rA: b\r\n\r\n",
        "GET / HTTP/1.1\r\nA: b\r\r\n\r\n",
    ] {
        let octets = [head.as_bytes(), LAST].concat();
        assert_eq!(outcome_of(&octets).await, Outcome::new(&[], &["400"]), "{head:?}");
    }
}

#[tokio::test]
async fn a_body_is_never_taken_for_a_head() {
    let body = "\n\n\r\n\r\nGET /hidden HTTP/1.1\n\n";
    let octets = format!("POST /body HTTP/1.1\r\nContent-Length: {}\r\n\r\n{body}", body.len());
    let octets = [octets.as_bytes(), LAST].concat();
    let executed = format!("POST /body {}", body.as_bytes().escape_ascii());
    assert_eq!(outcome_of(&octets).await, Outcome::new(&[&executed, "GET /last"], &["200", "200"]));
    // A body longer than a head, and longer than what is read at once.
    let body = "\n".repeat(MAX_HEAD + 2 * CHUNK + 1);
    let octets = format!("POST /body HTTP/1.1\r\nContent-Length: {}\r\n\r\n{body}", body.len());
    let octets = [octets.as_bytes(), LAST].concat();
    let executed = format!("POST /body {}", "\\n".repeat(body.len()));
    assert_eq!(outcome_of(&octets).await, Outcome::new(&[&executed, "GET /last"], &["200", "200"]));
}

#[tokio::test]
async fn a_body_in_chunks_is_the_last_on_its_connection() {
    let octets = b"POST /chunks HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n4\r\na\n\nb\r\n0\r\n\r\n";
    let octets = [octets.as_slice(), LAST].concat();
    assert_eq!(outcome_of(&octets).await, Outcome::new(&["POST /chunks a\\n\\nb"], &["200"]));
    let (_, answer) = exchange(std::iter::once(octets.as_slice())).await;
    assert!(answer.contains("\r\nconnection: close\r\n"), "{answer}");
}

#[tokio::test]
async fn a_request_with_two_lengths_is_refused_or_the_last_on_its_connection() {
    let both = b"POST /d HTTP/1.1\r\nContent-Length: 3\r\nTransfer-Encoding: chunked\r\n\r\n1\r\na\r\n0\r\n\r\n";
    let octets = [both.as_slice(), LAST].concat();
    assert_eq!(outcome_of(&octets).await, Outcome::new(&["POST /d a"], &["200"]));
    for head in [
        "POST /d HTTP/1.1\r\nContent-Length: 3\r\nContent-Length: 4\r\n\r\n",
        "POST /d HTTP/1.1\r\nContent-Length: 3, 4\r\n\r\n",
        "POST /d HTTP/1.1\r\nTransfer-Encoding: chunked, gzip\r\n\r\n",
        "POST /d HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n",
    ] {
        let octets = [head.as_bytes(), LAST].concat();
        assert_eq!(outcome_of(&octets).await, Outcome::new(&[], &["400"]), "{head:?}");
    }
}

#[test]
fn a_request_is_begun_only_where_a_head_has_ended() {
    let framing: Framing = Heads::new(tokio::io::empty()).framing();
    assert_eq!(framing.begin(&Body::empty()), Err(Refusal::Misplaced));
    framing.lock().then = super::Then::Request(None);
    assert_eq!(framing.begin(&Body::empty()), Ok(Reuse::Possible));
    assert_eq!(framing.begin(&Body::empty()), Err(Refusal::Misplaced));
}

/// A request, and what the server does with it.
struct Sent {
    octets: Vec<u8>,
    executed: Option<String>,
    status: &'static str,
    ends_the_connection: bool,
}

impl Sent {
    fn random(random: &mut Rng) -> Self {
        let body: String = (0..random.usize(..60)).map(|_| char::from(*random.choice(b"\r\n: 0a").unwrap())).collect();
        let escaped =
            |path: &str| Some(format!("POST {path} {}", body.as_bytes().escape_ascii()).trim_end().to_owned());
        let (octets, executed, status, ends_the_connection) = match random.u8(..9) {
            0 | 1 => ("GET /a HTTP/1.1\r\nHost: x\r\n\r\n".to_owned(), Some("GET /a".to_owned()), "200", false),
            2 => ("\r\n\r\nGET /b HTTP/1.1\r\n\r\n".to_owned(), Some("GET /b".to_owned()), "200", false),
            3 | 4 => {
                let head = format!("POST /c HTTP/1.1\r\nContent-Length: {}\r\n\r\n", body.len());
                (head + &body, escaped("/c"), "200", false)
            }
            5 => {
                let octets = head(MAX_HEAD - random.usize(..2));
                (String::from_utf8(octets).unwrap(), Some("GET /long".to_owned()), "200", false)
            }
            6 => {
                let chunk = if body.is_empty() { String::new() } else { format!("{:x}\r\n{body}\r\n", body.len()) };
                let head = "POST /d HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n";
                (format!("{head}{chunk}0\r\n\r\n"), escaped("/d"), "200", true)
            }
            7 => {
                let whole = "GET /e HTTP/1.1\r\nHost: x\r\nA: b\r\n\r\n";
                let line_ends: Vec<_> = whole.match_indices("\r\n").map(|(at, _)| at).collect();
                let at = *random.choice(&line_ends).unwrap();
                (format!("{}{}", &whole[..at], &whole[at + 1..]), None, "400", true)
            }
            _ => (String::from_utf8(head(MAX_HEAD + 1 + random.usize(..CHUNK))).unwrap(), None, "431", true),
        };
        Self { octets: octets.into_bytes(), executed, status, ends_the_connection }
    }

    fn last() -> Self {
        Self { octets: LAST.to_vec(), executed: Some("GET /last".to_owned()), status: "200", ends_the_connection: true }
    }
}

/// Cuts octets into random pieces, some of them of one octet and some longer than what is read at once.
fn cut<'a>(mut octets: &'a [u8], random: &mut Rng) -> Vec<&'a [u8]> {
    let mut pieces = Vec::new();
    while !octets.is_empty() {
        let longest = *random.choice(&[1, 4, 40, CHUNK, 3 * CHUNK]).unwrap();
        let (piece, rest) = octets.split_at(random.usize(1..=longest).min(octets.len()));
        pieces.push(piece);
        octets = rest;
    }
    pieces
}

#[tokio::test]
async fn the_pieces_in_which_requests_arrive_do_not_change_the_outcome() {
    for seed in 0..300 {
        println!("seed {seed}");
        let mut random = Rng::with_seed(seed);
        let mut sent: Vec<_> = (0..random.usize(..6)).map(|_| Sent::random(&mut random)).collect();
        sent.push(Sent::last());
        let mut expected = Outcome::default();
        for request in &sent {
            expected.executed.extend(request.executed.clone());
            expected.answered.push(request.status.to_owned());
            if request.ends_the_connection {
                break;
            }
        }
        let octets: Vec<u8> = sent.iter().flat_map(|request| request.octets.iter().copied()).collect();
        for _ in 0..3 {
            let pieces = cut(&octets, &mut random);
            let found = outcome(pieces.iter().copied()).await;
            assert_eq!(found, expected, "seed {seed}, {} octets in {} pieces", octets.len(), pieces.len());
        }
    }
}
