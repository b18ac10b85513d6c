//! An OpenID provider on loopback that says what a test tells it, signed or not.

use crate::security::test_station::TIMEOUT;
use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use profivac_web_server::auth::Role;
use profivac_web_server::auth::openid::{ClientSecret, OpenIdSettings};
use ring::rand::SystemRandom;
use ring::signature::{ECDSA_P256_SHA256_FIXED_SIGNING, EcdsaKeyPair, KeyPair};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::SystemTime;

/// What the provider answers to a request.
#[derive(Clone)]
pub enum Reply {
    Json(u16, Value),
    /// A body that never ends.
    Endless,
    /// The connection stays open and nothing comes.
    Silence,
}

/// What the provider answers, and what it was asked.
struct State {
    description: Mutex<Reply>,
    keys: Mutex<Reply>,
    token: Mutex<Reply>,
    /// Path and body of each request.
    asked: Mutex<Vec<(String, String)>>,
    held: Mutex<Vec<TcpStream>>,
}

/// A provider whose thread ends with the test program.
#[derive(Clone)]
pub struct TestProvider {
    pub issuer: String,
    state: Arc<State>,
}

impl TestProvider {
    /// A provider that describes itself correctly and publishes this key.
    pub fn start(key: &SigningKey) -> Self {
        let listener = TcpListener::bind(SocketAddr::from(([127, 0, 0, 1], 0))).unwrap();
        let issuer = format!("http://{}", listener.local_addr().unwrap());
        let state = Arc::new(State {
            description: Mutex::new(Reply::Json(200, description(&issuer))),
            keys: Mutex::new(Reply::Json(200, json!({ "keys": [key.public()] }))),
            token: Mutex::new(Reply::Json(400, json!({ "error": "invalid_grant" }))),
            asked: Mutex::default(),
            held: Mutex::default(),
        });
        let served = Arc::clone(&state);
        std::thread::spawn(move || {
            for stream in listener.incoming() {
                let state = Arc::clone(&served);
                std::thread::spawn(move || state.serve(stream.unwrap()));
            }
        });
        Self { issuer, state }
    }

    /// The settings of a station for this provider: the claim `groups` has the words of the roles.
    pub fn settings(&self) -> OpenIdSettings {
        OpenIdSettings {
            name: "Lab login".to_owned(),
            issuer: self.issuer.clone(),
            client_id: "profivac".to_owned(),
            client_secret: ClientSecret("a secret: with & signs".to_owned()),
            url: None,
            user_claim: "preferred_username".to_owned(),
            roles_claim: "groups".to_owned(),
            roles: Role::ALL.map(|role| (role.word().to_owned(), role)).into(),
            scopes: vec!["profile".to_owned()],
            trusted: Vec::new(),
            // Longer than any test.
            timeout: 10 * TIMEOUT,
        }
    }

    pub fn describe(&self, reply: Reply) {
        *self.state.description.lock().unwrap() = reply;
    }

    pub fn publish(&self, reply: Reply) {
        *self.state.keys.lock().unwrap() = reply;
    }

    /// Answers the next requests for a token so.
    pub fn issue(&self, reply: Reply) {
        *self.state.token.lock().unwrap() = reply;
    }

    /// The bodies of the requests at this path.
    pub fn asked(&self, path: &str) -> Vec<String> {
        let asked = self.state.asked.lock().unwrap();
        asked.iter().filter(|(other, _)| other == path).map(|(_, body)| body.clone()).collect()
    }

    /// The claims of a right token for a login with this nonce.
    pub fn claims(&self, nonce: &str) -> Value {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap().as_secs();
        json!({
            "iss": self.issuer, "aud": "profivac", "sub": "4711", "iat": now, "exp": now + 300, "nonce": nonce,
            "preferred_username": "erna", "groups": ["staff", "engineer"],
        })
    }
}

impl State {
    fn serve(&self, stream: TcpStream) {
        let mut reader = BufReader::new(stream.try_clone().unwrap());
        let (mut first, mut length) = (String::new(), 0);
        reader.read_line(&mut first).unwrap();
        loop {
            let mut line = String::new();
            reader.read_line(&mut line).unwrap();
            if let Some(value) = line.to_lowercase().strip_prefix("content-length:") {
                length = value.trim().parse().unwrap();
            }
            if line.trim().is_empty() {
                break;
            }
        }
        let mut body = vec![0; length];
        reader.read_exact(&mut body).unwrap();
        let path = first.split(' ').nth(1).unwrap_or_default().to_owned();
        let reply = match path.as_str() {
            "/.well-known/openid-configuration" => &self.description,
            "/keys" => &self.keys,
            _ => &self.token,
        };
        let reply = reply.lock().unwrap().clone();
        self.asked.lock().unwrap().push((path, String::from_utf8(body).unwrap()));
        self.answer(stream, reply);
    }

    fn answer(&self, mut stream: TcpStream, reply: Reply) {
        // The station may close the connection at any time.
        match reply {
            Reply::Json(status, value) => {
                let body = value.to_string();
                let head =
                    format!("HTTP/1.1 {status} Answer\r\nlocation: /keys\r\ncontent-length: {}\r\n\r\n", body.len());
                stream.write_all((head + &body).as_bytes()).unwrap_or_default();
            }
            Reply::Endless => {
                let mut sent = stream.write_all(b"HTTP/1.1 200 Answer\r\n\r\n");
                while sent.is_ok() {
                    sent = stream.write_all(&[b' '; 1 << 16]);
                }
            }
            Reply::Silence => self.held.lock().unwrap().push(stream),
        }
    }
}

/// The description of a provider.
pub fn description(issuer: &str) -> Value {
    json!({
        "issuer": issuer,
        "authorization_endpoint": format!("{issuer}/authorize?tenant=lab"),
        "token_endpoint": format!("{issuer}/token"),
        "jwks_uri": format!("{issuer}/keys"),
        "end_session_endpoint": format!("{issuer}/logout"),
    })
}

/// A key of the provider, for ES256.
pub struct SigningKey {
    pub id: &'static str,
    pair: EcdsaKeyPair,
}

impl SigningKey {
    pub fn new(id: &'static str) -> Self {
        let random = SystemRandom::new();
        let algorithm = &ECDSA_P256_SHA256_FIXED_SIGNING;
        let document = EcdsaKeyPair::generate_pkcs8(algorithm, &random).unwrap();
        Self { id, pair: EcdsaKeyPair::from_pkcs8(algorithm, document.as_ref(), &random).unwrap() }
    }

    /// The octets of the public key.
    pub fn octets(&self) -> Vec<u8> {
        self.pair.public_key().as_ref().to_vec()
    }

    /// The public key as JSON.
    pub fn public(&self) -> Value {
        let point = self.octets();
        let [x, y] = [&point[1..33], &point[33..]].map(|half| URL_SAFE_NO_PAD.encode(half));
        json!({ "kty": "EC", "crv": "P-256", "use": "sig", "kid": self.id, "x": x, "y": y })
    }

    /// A signed token.
    pub fn sign(&self, claims: &Value) -> String {
        self.sign_as(&json!({ "alg": "ES256", "kid": self.id }), claims)
    }

    /// A token with another header, signed with this key nevertheless.
    pub fn sign_as(&self, header: &Value, claims: &Value) -> String {
        let message = message(header, claims);
        let signature = self.pair.sign(&SystemRandom::new(), message.as_bytes()).unwrap();
        with_signature(&message, signature.as_ref())
    }
}

/// Header and claims of a token.
pub fn message(header: &Value, claims: &Value) -> String {
    [header, claims].map(|part| URL_SAFE_NO_PAD.encode(part.to_string())).join(".")
}

pub fn with_signature(message: &str, signature: &[u8]) -> String {
    format!("{message}.{}", URL_SAFE_NO_PAD.encode(signature))
}

/// The answer of the provider with a token.
pub fn token(token: &str) -> Reply {
    Reply::Json(200, json!({ "access_token": "a", "token_type": "Bearer", "id_token": token }))
}
