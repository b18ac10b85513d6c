//! One e-mail over SMTP, encrypted unless the server is on this computer.

use crate::alarm::{AlarmChangeKind, AlarmState};
use crate::config::{Email, MailSecurity};
use crate::view::mbar;
use jiff::Timestamp;
use jiff::tz::TimeZone;
use lettre::message::header::{ContentType, Header, HeaderName, HeaderValue};
use lettre::transport::smtp::authentication::Credentials;
use lettre::transport::smtp::client::{Certificate, Tls, TlsParameters};
use lettre::{AsyncSmtpTransport, AsyncTransport, Message, Tokio1Executor};
use profivac_recorder::alarms::Notification;
use profivac_web_server::tables::Secret;
use serde_json::Value;
use std::error::Error;
use std::fmt::Write;
use std::time::Duration;
use tokio_rustls::rustls::pki_types::CertificateDer;

/// The reason why a message is not sent.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MailError {
    /// The message cannot be written.
    #[error("the message cannot be written: {0}")]
    Message(#[from] lettre::error::Error),
    /// The server refuses, or there is no secure connection to it.
    #[error("{}", sentence(.0))]
    Smtp(#[from] lettre::transport::smtp::Error),
}

/// With these replies the server refuses the message itself, and would refuse it again: too large, and refused contents (RFC 5321, 4.2.3).
const PERMANENT_REFUSALS: [u16; 2] = [552, 554];

impl MailError {
    /// Whether the server would refuse this message again, and would take others.
    #[must_use]
    pub fn is_about_message(&self) -> bool {
        match self {
            Self::Message(_) => true,
            Self::Smtp(error) => error.status().is_some_and(|code| PERMANENT_REFUSALS.contains(&code.into())),
        }
    }
}

/// The error with its causes: the reply of the server is one of them.
fn sentence(error: &lettre::transport::smtp::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let words = error.to_string();
        if !text.contains(&words) {
            // Writing to a String cannot fail.
            let _ = write!(text, ": {words}");
        }
        cause = error.source();
    }
    text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect()
}

/// Sends messages to the recipients of an [`Email`].
pub struct Mailer {
    email: Email,
    transport: AsyncSmtpTransport<Tokio1Executor>,
}

impl Mailer {
    /// A mailer that trusts the certificates of the system and those in `trusted`, and waits for each reply at most for `timeout`.
    ///
    /// # Errors
    /// [`MailError`] when a certificate cannot be used.
    pub fn new(email: Email, trusted: Vec<CertificateDer<'static>>, timeout: Duration) -> Result<Self, MailError> {
        let parameters = || {
            let mut builder = TlsParameters::builder(email.host.clone());
            for certificate in trusted {
                builder = builder.add_root_certificate(Certificate::from_der(certificate.to_vec())?);
            }
            builder.build_rustls()
        };
        let tls = match email.security {
            MailSecurity::Starttls => Tls::Required(parameters()?),
            MailSecurity::Tls => Tls::Wrapper(parameters()?),
            MailSecurity::None => Tls::None,
        };
        // The name says that TLS is not the default; it is set in the same line.
        let mut transport =
            AsyncSmtpTransport::<Tokio1Executor>::builder_dangerous(&email.host).port(email.port).tls(tls);
        if let Some((user, password)) = &email.credentials {
            transport = transport.credentials(Credentials::new(user.clone(), Secret::reveal(password).to_owned()));
        }
        let transport = transport.timeout(Some(timeout)).build();
        Ok(Self { email, transport })
    }

    /// Sends a notification to all recipients.
    ///
    /// # Errors
    /// [`MailError`] with the reply of the server.
    pub async fn send(&self, notification: &Notification) -> Result<(), MailError> {
        self.transport.send(message(&self.email, notification)?).await?;
        Ok(())
    }
}

/// The header that tells other mail programs not to answer (RFC 3834).
#[derive(Clone)]
struct AutoSubmitted;

impl Header for AutoSubmitted {
    fn name() -> HeaderName {
        HeaderName::new_from_ascii_str("Auto-Submitted")
    }

    fn parse(_text: &str) -> Result<Self, Box<dyn Error + Send + Sync>> {
        Ok(Self)
    }

    fn display(&self) -> HeaderValue {
        HeaderValue::new(Self::name(), "auto-generated".to_owned())
    }
}

fn message(email: &Email, notification: &Notification) -> Result<Message, lettre::error::Error> {
    // The station has written the body, so it is an object.
    let body: Value = serde_json::from_str(&notification.body).unwrap_or_default();
    // The same in each attempt: mail programs recognise a message that came twice.
    let id = format!("<{}-{}@{}>", notification.at.0, notification.id, email.from.email.domain());
    let builder = Message::builder().from(email.from.clone()).subject(subject(&body)).message_id(Some(id));
    let builder = email.to.iter().fold(builder, |builder, to| builder.to(to.clone()));
    builder.header(AutoSubmitted).header(ContentType::TEXT_PLAIN).body(text(email, &body))
}

/// The words of a key; empty if it is `null`. Line ends and other control characters become spaces.
fn word(body: &Value, key: &str) -> String {
    let text = body.get(key).and_then(Value::as_str).unwrap_or_default();
    text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect()
}

/// The change, in the words of the dashboard.
fn change(body: &Value) -> String {
    let change = word(body, "change");
    AlarmChangeKind::from_word(&change).map_or_else(|| change.replace('-', " "), AlarmChangeKind::operator_words)
}

/// The state, in the words of the dashboard.
fn state(body: &Value) -> String {
    let state = word(body, "state");
    AlarmState::from_word(&state).map_or(state, |state| state.operator_words().to_owned())
}

fn subject(body: &Value) -> String {
    let [station, alarm, priority] = ["station", "alarm", "priority"].map(|key| word(body, key));
    format!("{station}: {alarm} {} ({priority})", change(body))
}

/// A value with its unit; pressures in mbar.
fn quantity(body: &Value, key: &str) -> String {
    let Some(value) = body.get(key).and_then(Value::as_f64) else { return String::new() };
    match body.get("unit").and_then(Value::as_str) {
        Some("Pa") => mbar(value),
        Some(unit) => format!("{value:.3} {unit}"),
        None => format!("{value}"),
    }
}

fn text(email: &Email, body: &Value) -> String {
    let at = body.get("at_ms").and_then(Value::as_i64).and_then(|ms| Timestamp::from_millisecond(ms).ok());
    let zoned = at.map(|at| at.to_zoned(TimeZone::system()).strftime("%Y-%m-%d %H:%M:%S %:z").to_string());
    let lines = [
        ("Alarm", word(body, "alarm")),
        ("Change", change(body)),
        ("By", word(body, "user")),
        ("Priority", word(body, "priority")),
        ("State", state(body)),
        ("Gauge", word(body, "subject")),
        ("Value", quantity(body, "value")),
        ("Limit", quantity(body, "limit")),
        ("Time", zoned.unwrap_or_default()),
        ("Station", word(body, "station")),
        ("Dashboard", email.link.as_ref().map(|link| format!("{link}/alarms")).unwrap_or_default()),
    ];
    let mut text = String::new();
    for paragraph in [word(body, "text"), word(body, "message")].into_iter().filter(|words| !words.is_empty()) {
        text.push_str(&paragraph);
        text.push_str("\r\n\r\n");
    }
    for (label, value) in lines.into_iter().filter(|(_, value)| !value.is_empty()) {
        // Writing to a String cannot fail.
        let _ = write!(text, "{:<11}{value}\r\n", format!("{label}:"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alarm::Priority;
    use profivac_recorder::Micros;
    use serde_json::json;
    use std::time::Duration;

    fn email() -> Email {
        Email {
            name: "localhost".to_owned(),
            host: "localhost".to_owned(),
            port: 25,
            security: MailSecurity::None,
            from: "Hall <a@example.org>".parse().unwrap(),
            to: vec!["b@example.org".parse().unwrap()],
            credentials: None,
            ca_file: None,
            link: Some("https://vacuum.example".to_owned()),
            min_priority: Priority::Low,
            unacknowledged_after: Duration::ZERO,
            quiet: None,
        }
    }

    fn formatted(body: &Value) -> String {
        let at = Micros(1_767_225_600_000_000);
        let notification = Notification { id: 7, webhook: "x".to_owned(), at, body: body.to_string() };
        String::from_utf8(message(&email(), &notification).unwrap().formatted()).unwrap()
    }

    #[test]
    fn a_name_cannot_add_a_header_or_a_recipient() {
        let evil = "x\r\nBcc: eve@example.org\r\n\r\nhello\u{0}";
        let body =
            json!({ "station": evil, "alarm": evil, "change": evil, "priority": evil, "text": evil, "user": evil });
        let text = formatted(&body);
        let (head, _) = text.split_once("\r\n\r\n").unwrap();
        let names: Vec<_> =
            head.lines().filter(|line| !line.starts_with(' ')).map(|line| line.split(':').next().unwrap()).collect();
        let expected = [
            "From",
            "Subject",
            "Message-ID",
            "To",
            "Auto-Submitted",
            "Content-Type",
            "Date",
            "Content-Transfer-Encoding",
        ];
        let (mut names, mut expected) = (names, expected.to_vec());
        names.sort_unstable();
        expected.sort_unstable();
        assert_eq!(names, expected, "{head}");
    }

    #[test]
    fn a_message_has_the_same_id_in_each_attempt() {
        let text = formatted(&json!({}));
        assert!(text.contains("Message-ID: <1767225600000000-7@example.org>"), "{text}");
        assert!(text.contains("Auto-Submitted: auto-generated"), "{text}");
    }
}
