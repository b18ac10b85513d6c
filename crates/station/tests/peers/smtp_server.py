"""A mail server (aiosmtpd) for tests. Prints its port, then a line of JSON for each message.

usage: smtp_server.py (starttls|tls|none) CERTIFICATE KEY [REPLY ...]

Each REPLY is that of one message, the last one repeated: 250 accepts. With starttls and tls a login is required.
"""

import asyncio
import email
import email.policy
import json
import ssl
import sys

from aiosmtpd.smtp import SMTP, AuthResult, LoginPassword


class Handler:
    def __init__(self, replies):
        self.replies = replies

    async def handle_DATA(self, server, session, envelope):
        reply = self.replies.pop(0) if len(self.replies) > 1 else self.replies[0]
        parsed = email.message_from_bytes(envelope.content, policy=email.policy.default)
        said = {
            "reply": reply,
            "sender": envelope.mail_from,
            "recipients": envelope.rcpt_tos,
            "headers": [[name, str(value)] for name, value in parsed.items()],
            "text": parsed.get_content(),
            "encrypted": session.ssl is not None or implicit,
            "user": session.auth_data.login.decode() if session.auth_data else None,
        }
        print(json.dumps(said), flush=True)
        return {"250": "250 taken", "451": "451 try later", "554": "554 refused"}[reply]


def authenticate(server, session, envelope, mechanism, data):
    correct = isinstance(data, LoginPassword) and (data.login, data.password) == (b"profivac", b"tin whisker")
    return AuthResult(success=correct, auth_data=data if correct else None, handled=False)


async def main():
    context = None
    if mode != "none":
        context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
        context.load_cert_chain(certificate, key)
    handler = Handler(replies or ["250"])
    options = {"hostname": "localhost", "enable_SMTPUTF8": True}
    if mode != "none":
        options |= {"auth_required": True, "authenticator": authenticate, "auth_require_tls": mode == "starttls"}
    if mode == "starttls":
        options |= {"tls_context": context, "require_starttls": True}
    loop = asyncio.get_running_loop()
    server = await loop.create_server(
        lambda: SMTP(handler, **options), "127.0.0.1", 0, ssl=context if implicit else None
    )
    print(server.sockets[0].getsockname()[1], flush=True)
    # The server ends with its parent.
    await loop.run_in_executor(None, sys.stdin.read)
    server.close()


mode, certificate, key, *replies = sys.argv[1:]
implicit = mode == "tls"
asyncio.run(main())
