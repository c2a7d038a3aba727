"""Live pages in the browser, served until they are closed, for whoever knows their address."""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import logging
import secrets
import threading
import time
import webbrowser
from collections.abc import Callable, Sequence
from dataclasses import replace
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, Generic, Literal, Protocol, TypeVar

from leadthrough import check
from leadthrough.check import InvalidInput, MissingDependency, ShortRepr
from leadthrough.show.live_session import LiveSession
from leadthrough.show.replanner import Answer

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

# Any web page that a browser has open may send requests to 127.0.0.1, by a name of its own that it
# lets point there (DNS rebinding) or across sites; so may any program of another user. The server
# therefore answers only where the path begins with a random token, the host is this machine's and
# the origin, where there is one, is the server's own page.
_TOKEN_BYTES = 24
_REFUSED = "Open the address that leadthrough printed, with all of its letters.\n"

# Called by websockets before it answers: None lets a WebSocket be opened.
Reply = Callable[["ServerConnection", "Request"], "Response | None"]


def guarding(answer: Reply, token: str) -> Reply:
    """The answer for those who know the token, from pages of this server; 403 for others."""

    def guarded(connection: ServerConnection, request: Request) -> Response | None:
        given, _, rest = request.path.removeprefix("/").partition("/")
        given = given.partition("?")[0]
        known = hmac.compare_digest(given.encode("utf-8", "replace"), token.encode())
        if not known or not _is_from_here(request, connection.local_address[1]):
            return connection.respond(HTTPStatus.FORBIDDEN, _REFUSED)
        response = answer(connection, replace(request, path=f"/{rest}"))
        if response is not None:
            response.headers["Referrer-Policy"] = "no-referrer"  # the address is the secret
            response.headers["Cache-Control"] = "no-store"
        return response

    return guarded


def _is_from_here(request: Request, port: int) -> bool:
    hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
    named = request.headers.get_all("Host")
    origins = request.headers.get_all("Origin")
    return (
        len(named) == 1
        and named[0] in hosts
        and all(origin.removeprefix("http://") in hosts for origin in origins)
    )


# Longer messages of a browser are refused, bytes.
_MAX_MESSAGE = 65536
_SOCKET = "/live"


class Session(Protocol):
    """A live page's other side; all methods are called from one thread."""

    def greeting(self) -> Sequence[str]:
        """Messages to a browser that has just opened the page."""

    def hear(self, message: str) -> None:
        """Takes a message of a browser, of any content."""

    def advance(self, dt: float) -> Sequence[str]:
        """Messages to all browsers, dt s after the last call."""

    def left(self) -> None:
        """The last browser has closed the page."""


class PageServer:
    """A page, and a websocket between all browsers that show it and a session."""

    def __init__(self, document: str, session: Session, *, port: int, period: float) -> None:
        try:
            import websockets  # noqa: F401, PLC0415
        except ImportError:
            raise MissingDependency("websockets", extra="view") from None
        self._document, self._session, self._period = document, session, period
        self._token = secrets.token_urlsafe(_TOKEN_BYTES)
        self._ready, self._closing = threading.Event(), threading.Event()
        self._trouble: OSError | None = None
        self._port = port
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve()), daemon=True)
        self._thread.start()
        self._ready.wait()
        if self._trouble is not None:
            raise InvalidInput(f"port: cannot listen on {port} ({self._trouble.strerror})")

    @property
    def url(self) -> str:
        """The page's URL; the token in it keeps others out."""
        return f"http://127.0.0.1:{self._port}/{self._token}/"

    def close(self) -> None:
        """Stops the server."""
        self._closing.set()
        self._thread.join()

    async def _serve(self) -> None:
        from websockets.asyncio.server import broadcast, serve  # noqa: PLC0415

        quiet = logging.Logger("leadthrough", logging.CRITICAL)  # nobody reads it
        answer = guarding(self._answer, self._token)
        try:
            server = await serve(
                *(self._talk, "127.0.0.1", self._port),
                process_request=answer, max_size=_MAX_MESSAGE, logger=quiet, close_timeout=0.2,
            )  # fmt: skip
        except OSError as error:
            self._trouble = error
            self._ready.set()
            return
        async with server:
            self._port = next(iter(server.sockets)).getsockname()[1]
            self._ready.set()
            last = due = time.monotonic()
            while not self._closing.is_set():
                due = max(due + self._period, last)
                await asyncio.sleep(max(due - time.monotonic(), 0.0))
                last, before = time.monotonic(), last
                for message in self._session.advance(last - before):
                    broadcast(server.connections, message)

    async def _talk(self, connection: ServerConnection) -> None:
        from websockets.exceptions import ConnectionClosed  # noqa: PLC0415

        with contextlib.suppress(ConnectionClosed):
            for message in self._session.greeting():
                await connection.send(message)
            async for heard in connection:
                self._session.hear(heard if isinstance(heard, str) else "")
        if not connection.server.connections - {connection}:
            self._session.left()

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        path = request.path.partition("?")[0]
        if path == _SOCKET:
            return None
        if path != "/":
            return connection.respond(HTTPStatus.NOT_FOUND, "There is one page, at /.\n")
        response: Any = connection.respond(HTTPStatus.OK, self._document)
        del response.headers["Content-Type"]
        response.headers["Content-Type"] = "text/html; charset=utf-8"
        return response  # type: ignore[no-any-return]


# Time between looks at what is to be told, s: of an arm that is led also that of its steps.
_PERIODS = {"teach": 0.02, "view": 0.005}

SessionT = TypeVar("SessionT", bound=LiveSession)


class LivePage(ShortRepr, Generic[SessionT]):
    """A running live page.

    Attributes:
        session: the state of the page.
        url: of the page; the token in it keeps others out.
    """

    def __init__(self, session: SessionT, kind: Literal["teach", "view"], port: int) -> None:
        check.integer(port, "port", at_least=0, at_most=65535)
        self.session = session
        self._closed = threading.Event()
        document, period = session.drawn.document(kind), _PERIODS[kind]
        self._server = PageServer(document, session, port=port, period=period)
        self.url = self._server.url

    def _repr_parts(self) -> list[str]:
        return [self.url]

    @property
    def answer(self) -> Answer | None:
        """The latest plan or preview; None before the first, and without a skill."""
        return self.session.answer

    def open(self) -> None:
        """Opens the page in the user's browser."""
        webbrowser.open(self.url)

    def wait(self) -> None:
        """Returns when the page has been closed; Ctrl-C closes it."""
        try:
            self._closed.wait()
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        """Stops the page's server; a recording that is running is kept."""
        self._server.close()
        self.session.close()
        self._closed.set()
