"""What keeps other web pages out: headers of all answers, and whose requests are taken."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOCAL: Final = ("127.0.0.1", "localhost", "[::1]")
EVERYWHERE: Final = ("0.0.0.0", "::")
POLICY_VIOLATION: Final = 1008
POLICY: Final = (
    "default-src 'self'; img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; "
    "form-action 'none'; object-src 'none'; frame-ancestors 'self'"
)


def hosts_of(host: str) -> tuple[str, ...]:
    """Names by which a server at this address may be asked; none if it is at all addresses."""
    if host in EVERYWHERE:
        return ()
    return (*LOCAL, f"[{host}]" if ":" in host else host)


class SafeHeaders:
    """Add headers to every answer, and refuse requests of other sites' pages."""

    # Browsers name the page's origin with what it posts and with WebSockets. A site that has its
    # own name resolved to this machine names a foreign host: `hosts` are taken, any if empty.

    def __init__(self, app: ASGIApp, *, hosts: tuple[str, ...], framed_by: tuple[str, ...]) -> None:
        self.app = app
        self.hosts = hosts
        self.headers = {
            "content-security-policy": " ".join((POLICY, *framed_by)),
            "x-content-type-options": "nosniff",
            "referrer-policy": "no-referrer",
            "cross-origin-resource-policy": "same-origin",
            "permissions-policy": "camera=(), geolocation=(), microphone=()",
            "cache-control": "no-cache",
        }

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        if not self._is_ours(Headers(scope=scope)):
            await self._refuse(scope, receive, send)
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in self.headers.items():
                    headers[name] = value
            await send(message)

        await self.app(scope, receive, send_with_headers)

    def _is_ours(self, headers: Headers) -> bool:
        host = headers.get("host", "")
        name = host[: host.rfind(":")] if host.rpartition(":")[2].isdigit() else host
        origin = headers.get("origin")
        foreign = origin is not None and urlsplit(origin).netloc != host
        return not foreign and (not self.hosts or name in self.hosts)

    async def _refuse(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": POLICY_VIOLATION})
            return
        answer = PlainTextResponse("a request of another site\n", status_code=403)
        await answer(scope, receive, send)
