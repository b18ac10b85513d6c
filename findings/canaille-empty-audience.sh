#!/usr/bin/env bash
# Canaille 0.3.6: the ID tokens of a client that `canaille create client` made have an empty audience.
#
# Expected: the audience of an ID token contains the client that asked for it. OpenID Connect Core 1.0, section 2: `aud` must contain the
# client_id of the relying party; section 3.1.3.7: a client must refuse a token without it.
#
# Seen: a client made on the command line logs its user in, and the ID token has `"aud": []`. With `canaille set client ... --audience ID`,
# the ID of the client itself, the audience is the client. Nothing in the output of the two commands says that it was missing.
#
# Why it matters: every client that checks the token refuses the login of a user whose password was right, and a client that accepts the
# empty list takes tokens that were made for others.
set -euo pipefail
folder=$(mktemp -d)
canaille_process=
trap '[ -z "$canaille_process" ] || kill "$canaille_process" 2>/dev/null || true; rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check 'canaille[front,oidc,server,sqlite]==0.3.6' requests==2.34.2
export CONFIG=$folder/canaille.toml
port=$(python3 -c 'import socket; free = socket.socket(); free.bind(("127.0.0.1", 0)); print(free.getsockname()[1])')
cat >canaille.toml <<TOML
SECRET_KEY = "an invented value"
SERVER_NAME = "127.0.0.1:$port"
PREFERRED_URL_SCHEME = "http"
[CANAILLE]
DATABASE = "sql"
[CANAILLE_SQL]
DATABASE_URI = "sqlite:///$folder/canaille.sqlite"
[CANAILLE_OIDC]
TOML
canaille() { venv/bin/canaille "$@" 2>>canaille.log; }
canaille jwk create rsa >key.json
python3 -c '
import json
key = json.load(open("key.json"))
print("ACTIVE_JWKS = [{" + ", ".join(f"{name} = \"{value}\"" for name, value in key.items()) + "}]")' >>canaille.toml
canaille install >/dev/null
canaille create user --user-name ada --given-name Ada --family-name Example --formatted-name 'Ada Example' --display-name ada \
    --emails ada@lab.example --password invented-1-password >/dev/null
client=$(canaille create client --client-name gauges --client-id gauges --client-secret invented --redirect-uris http://127.0.0.1:9/openid \
    --grant-types authorization_code --response-types code --scope openid --token-endpoint-auth-method client_secret_basic |
    python3 -c 'import json, sys; print(json.load(sys.stdin)["id"])')
venv/bin/canaille run --bind "127.0.0.1:$port" >>canaille.log 2>&1 &
canaille_process=$!

cat >login.py <<'PYTHON'
import base64
import html
import json
import re
import sys
import time
import urllib.parse

import requests

provider = f"http://127.0.0.1:{sys.argv[1]}"
session = requests.Session()
for _ in range(300):
    try:
        known = session.get(provider + "/.well-known/openid-configuration", timeout=10).json()
        break
    except requests.ConnectionError:
        time.sleep(0.2)
else:
    sys.exit("Canaille does not answer")
answers = {"login": "ada", "password": "invented-1-password", "answer": "accept"}
asked = {"response_type": "code", "client_id": "gauges", "redirect_uri": "http://127.0.0.1:9/openid", "scope": "openid", "state": "s", "nonce": "n"}


def follow(page):
    """Follows redirections up to the one to the client."""
    while page.is_redirect:
        target = urllib.parse.urljoin(page.url, page.headers["location"])
        if target.startswith(asked["redirect_uri"]):
            return None, target
        page = session.get(target, allow_redirects=False, timeout=10)
    return page, None


page, target = follow(session.get(known["authorization_endpoint"], params=asked, allow_redirects=False, timeout=10))
while target is None:
    # The form that asks for something that is known: the name, the password, the consent.
    for form in re.findall(r"<form.*?</form>", page.text, re.S):
        fields = {}
        for tag in re.findall(r"<(?:input|button)[^>]*>", form):
            name, value = re.search(r'name="([^"]*)"', tag), re.search(r'value="([^"]*)"', tag)
            if name:
                fields[name[1]] = html.unescape(value[1]) if value else ""
        wanted = [name for name in answers if name in fields]
        if wanted:
            break
    else:
        sys.exit(f"no form of Canaille that is known at {page.url}")
    fields[wanted[0]] = answers.pop(wanted[0])
    action = re.search(r'action="([^"]*)"', form)
    url = urllib.parse.urljoin(page.url, html.unescape(action[1])) if action and action[1] else page.url
    page, target = follow(session.post(url, data=fields, allow_redirects=False, timeout=10))
code = urllib.parse.parse_qs(urllib.parse.urlparse(target).query)["code"][0]
grant = {"grant_type": "authorization_code", "code": code, "redirect_uri": asked["redirect_uri"]}
token = requests.post(known["token_endpoint"], data=grant, auth=("gauges", "invented"), timeout=10).json()["id_token"]
body = token.split(".")[1]
print(json.loads(base64.urlsafe_b64decode(body + "=" * (-len(body) % 4)))["aud"])
PYTHON

login() { timeout 120 venv/bin/python login.py "$port"; }
before=$(login)
canaille set client "$client" --audience "$client" >/dev/null
after=$(login)
echo "audience of the ID token: $before; after 'canaille set client --audience': $after"
if [ "$before" != '[]' ]; then echo "Canaille changed: the audience was $before and not empty"; exit 1; fi
if [ "$after" != "['gauges']" ]; then echo "Canaille changed: the audience was $after and not ['gauges']"; exit 1; fi
echo 'as described: Canaille 0.3.6 gives ID tokens without an audience to a client of the command line'
