//! The user in the claims of an ID token: name and role at this station.

use super::settings::OpenIdSettings;
use super::token::Claims;
use crate::auth::{Role, User};
use crate::visible_text::{TextProblem, check_name};
use serde_json::Value;
use std::sync::Arc;
use unicode_security::confusable_detection::skeleton;
use unicode_security::{RestrictionLevel, RestrictionLevelDetection};

/// What the names of these users begin with. No user of the file is called so: names there have no colon.
pub const NAME_PREFIX: &str = "openid:";

/// The most characters of a name at the provider. chosen: an e-mail address of usual length.
const MAX_NAME: usize = 64;

/// The longest `sub` (OpenID Connect Core 1.0, 2).
const MAX_SUBJECT: usize = 255;

/// A user of the provider.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Name and role at this station.
    pub user: User,
    /// What the provider calls the user for ever: `sub`.
    pub subject: Arc<str>,
}

/// Why the claims are not those of a user of this station.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum IdentityProblem {
    /// There is no name.
    #[error("expected the name of the user in the claim {0}, as a text of 1 to {MAX_NAME} characters")]
    NoName(String),
    /// The name is not visible text, or a path.
    #[error("the claim {claim} has no usable name: {problem}")]
    Name {
        /// The claim.
        claim: String,
        /// The reason.
        problem: TextProblem,
    },
    /// The name looks like another one.
    #[error(
        "the name in the claim {0} has letters of several alphabets, or letters that look like Latin ones, and could be taken for the name \
         of another user: choose another claim with user-claim in [openid], or change the name at the provider"
    )]
    Imitation(String),
    /// The provider has not checked the e-mail address that is the name.
    #[error("the claim email has an address that the provider has not verified (email_verified)")]
    Unverified,
    /// There is no subject.
    #[error("expected the claim sub with 1 to {MAX_SUBJECT} characters")]
    Subject,
    /// The user has no role here.
    #[error(
        "{name} has no role at this station: expected in the claim {claim} a value that the station's file maps to a role, found {found}"
    )]
    NoRole {
        /// The user.
        name: String,
        /// The claim.
        claim: String,
        /// What the claim has.
        found: &'static str,
    },
}

/// Whether a user of this name logs in at the provider.
#[must_use]
pub fn is_openid(name: &str) -> bool {
    name.starts_with(NAME_PREFIX)
}

impl Identity {
    /// The user of these claims.
    ///
    /// # Errors
    /// [`IdentityProblem`].
    pub fn of(claims: &Claims, settings: &OpenIdSettings) -> Result<Self, IdentityProblem> {
        let name = name(claims, &settings.user_claim)?;
        let subject = claims.get("sub").and_then(Value::as_str);
        let subject = subject.filter(|subject| (1..=MAX_SUBJECT).contains(&subject.len()));
        let subject = subject.ok_or(IdentityProblem::Subject)?;
        let values = values(claim(claims, &settings.roles_claim));
        let roles = settings.roles.iter().filter(|(value, _)| values.contains(&value.as_str()));
        let role: Role = roles.map(|(_, role)| *role).max().ok_or_else(|| IdentityProblem::NoRole {
            name: name.clone(),
            claim: settings.roles_claim.clone(),
            found: if values.is_empty() { "none" } else { "others only" },
        })?;
        Ok(Self { user: User { name: Arc::from(name), role }, subject: Arc::from(subject) })
    }
}

fn name(claims: &Claims, path: &str) -> Result<String, IdentityProblem> {
    let name = claim(claims, path).and_then(Value::as_str);
    let name = name.filter(|name| (1..=MAX_NAME).contains(&name.chars().count()));
    let name = name.ok_or_else(|| IdentityProblem::NoName(path.to_owned()))?;
    check_name(name).map_err(|problem| IdentityProblem::Name { claim: path.to_owned(), problem })?;
    if imitates(name) {
        return Err(IdentityProblem::Imitation(path.to_owned()));
    }
    if path == "email" && claims.get("email_verified") != Some(&Value::Bool(true)) {
        return Err(IdentityProblem::Unverified);
    }
    Ok(format!("{NAME_PREFIX}{name}"))
}

/// Whether a name could be taken for another one: it mixes alphabets that no language mixes (UTS 39, 5.2, highly restrictive), or people
/// read it as a name in ASCII, which it is not (UTS 39, 4).
fn imitates(name: &str) -> bool {
    // An address has signs, such as @, that no identifier has.
    let letters: String = name.chars().filter(|character| character.is_alphanumeric()).collect();
    let is_mixed = !letters.as_str().check_restriction_level(RestrictionLevel::HighlyRestrictive);
    is_mixed || (!name.is_ascii() && skeleton(name).all(|character| character.is_ascii()))
}

/// The claim of this name, or else at this path: `realm_access.roles`. Names of claims may contain dots.
fn claim<'a>(claims: &'a Claims, path: &str) -> Option<&'a Value> {
    claims.get(path).or_else(|| {
        let mut parts = path.split('.');
        let first = claims.get(parts.next()?);
        parts.try_fold(first?, |value, part| value.get(part))
    })
}

/// The texts of a claim: one, or a list.
fn values(claim: Option<&Value>) -> Vec<&str> {
    match claim {
        Some(Value::Array(all)) => all.iter().filter_map(Value::as_str).collect(),
        Some(Value::String(one)) => vec![one],
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::settings::{ClientSecret, TIMEOUT};
    use super::*;
    use serde_json::json;

    #[test]
    fn a_name_that_people_read_as_another_one_is_refused() {
        // Latin with Cyrillic, Cyrillic alone, Greek alone, letters for mathematics, wide letters.
        for name in
            ["\u{430}da", "\u{430}\u{441}\u{430}", "\u{3bf}\u{3bd}\u{3bf}", "\u{1d41a}da", "\u{ff41}da", "ada\u{43b}"]
        {
            assert!(imitates(name), "{name}");
        }
        for name in ["ada", "Ada.Lovelace@example.org", "müller", "Łukasz", "анна", "ελένη", "山田太郎", "straße"]
        {
            assert!(!imitates(name), "{name}");
        }
        let claims = json!({ "sub": "1", "name": "\u{430}da", "r": "vacuum" });
        let refused = Identity::of(claims.as_object().unwrap(), &settings("name", "r"));
        assert_eq!(refused, Err(IdentityProblem::Imitation("name".to_owned())));
    }

    fn settings(user_claim: &str, roles_claim: &str) -> OpenIdSettings {
        let roles = [("vacuum-viewer", Role::Viewer), ("vacuum", Role::Operator), ("vacuum-admin", Role::Engineer)];
        OpenIdSettings {
            name: "Keycloak".to_owned(),
            issuer: "https://login.example".to_owned(),
            client_id: "profivac".to_owned(),
            client_secret: ClientSecret("secret".to_owned()),
            url: None,
            user_claim: user_claim.to_owned(),
            roles_claim: roles_claim.to_owned(),
            roles: roles.map(|(value, role)| (value.to_owned(), role)).into(),
            scopes: Vec::new(),
            trusted: Vec::new(),
            timeout: TIMEOUT,
        }
    }

    fn identity(claims: &Value, roles_claim: &str) -> Result<Identity, IdentityProblem> {
        Identity::of(claims.as_object().unwrap(), &settings("preferred_username", roles_claim))
    }

    #[test]
    fn the_highest_role_of_the_claim_counts() {
        let claims = |roles: Value| json!({ "sub": "1", "preferred_username": "ada", "groups": roles });
        for (roles, role) in [
            (json!(["vacuum-viewer"]), Role::Viewer),
            (json!(["other", "vacuum", "vacuum-viewer", 5]), Role::Operator),
            (json!(["vacuum-admin", "vacuum-viewer"]), Role::Engineer),
            (json!("vacuum"), Role::Operator),
        ] {
            let found = identity(&claims(roles.clone()), "groups").unwrap();
            assert_eq!((&*found.user.name, found.user.role, &*found.subject), ("openid:ada", role, "1"), "{roles}");
        }
    }

    #[test]
    fn a_user_without_a_mapped_role_is_refused_with_the_name_of_the_claim() {
        for (groups, found) in [
            (json!([]), "none"),
            (json!(["VACUUM", "vacuum ", "vacuum,vacuum-admin"]), "others only"),
            (json!({ "vacuum": true }), "none"),
            (json!(true), "none"),
            (json!(null), "none"),
        ] {
            let claims = json!({ "sub": "1", "preferred_username": "ada", "groups": groups });
            let error = identity(&claims, "groups").unwrap_err().to_string();
            let expected = "openid:ada has no role at this station: expected in the claim groups a value that the \
                            station's file maps to a role, found ";
            assert_eq!(error, format!("{expected}{found}"), "{groups}");
        }
    }

    #[test]
    fn a_claim_is_found_by_its_name_and_by_its_path() {
        let nested = json!({ "sub": "1", "preferred_username": "ada", "realm_access": { "roles": ["vacuum"] } });
        assert_eq!(identity(&nested, "realm_access.roles").unwrap().user.role, Role::Operator);
        for path in ["realm_access", "roles", "realm_access.roles.0", "realm_access..roles", ".", ""] {
            assert!(matches!(identity(&nested, path), Err(IdentityProblem::NoRole { .. })), "{path}");
        }
        let dotted = json!({ "sub": "1", "preferred_username": "ada", "https://lab.example/roles": ["vacuum"] });
        assert!(identity(&dotted, "https://lab.example/roles").is_ok());
    }

    #[test]
    fn a_name_is_visible_text_and_an_address_is_verified() {
        let with =
            |name: Value| identity(&json!({ "sub": "1", "preferred_username": name, "groups": "vacuum" }), "groups");
        assert!(with(json!("Ada Lovelace")).is_ok());
        for name in [json!(""), json!(5), json!(null), json!(["ada"]), json!("a".repeat(65))] {
            assert!(matches!(with(name.clone()), Err(IdentityProblem::NoName(_))), "{name}");
        }
        for name in ["a\u{202E}b", "a\nb", " ada", "../ada"] {
            assert!(matches!(with(json!(name)), Err(IdentityProblem::Name { .. })), "{name:?}");
        }
        for (verified, is_right) in
            [(json!(true), true), (json!(false), false), (json!("true"), false), (json!(null), false)]
        {
            let claims =
                json!({ "sub": "1", "email": "ada@lab.example", "email_verified": verified, "groups": "vacuum" });
            let found = Identity::of(claims.as_object().unwrap(), &settings("email", "groups"));
            assert_eq!(found.is_ok(), is_right, "{verified}");
        }
    }

    #[test]
    fn a_user_has_a_subject() {
        for subject in [json!(null), json!(""), json!(7), json!("a".repeat(256))] {
            let claims = json!({ "sub": subject, "preferred_username": "ada", "groups": "vacuum" });
            assert_eq!(identity(&claims, "groups"), Err(IdentityProblem::Subject));
        }
    }
}
