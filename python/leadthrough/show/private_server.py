"""A viser server for those who know its address, and for nobody else.

Any web page that a browser has open may send requests to 127.0.0.1, by a name of its own that it
lets point there (DNS rebinding) or across sites; so may any program of another user. The server
therefore answers only where the path begins with a random token, the host is this machine's and
the origin, where there is one, is the server's own page. viser has no option for this: the function
with which it starts to listen is replaced while it does.
"""

from __future__ import annotations

import contextlib
import hmac
import io
import secrets
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, TextIO

from leadthrough.check import MissingDependency

if TYPE_CHECKING:
    import viser
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

_TOKEN_BYTES = 24
_REFUSED = "Open the address that leadthrough printed, with all of its letters.\n"

# Called by websockets before it answers: None lets a WebSocket be opened.
Answer = Callable[["ServerConnection", "Request"], "Response | None"]

_starting = threading.Lock()


class PrivateServer:
    """A running viser server and its address."""

    def __init__(self, port: int) -> None:
        try:
            import viser  # noqa: PLC0415
        except ImportError:
            raise MissingDependency("viser", extra="view") from None
        token = secrets.token_urlsafe(_TOKEN_BYTES)
        with _starting, _guarded_by(token) as guarded, silence():
            self.server: viser.ViserServer = viser.ViserServer(
                host="127.0.0.1", port=port, verbose=False
            )
        self.url = f"http://127.0.0.1:{self.server.get_port()}/{token}/"
        if not guarded:
            self.stop()
            raise MissingDependency("a viser that serves by websockets", extra="view")

    def stop(self) -> None:
        """Stops the server."""
        with silence():
            self.server.stop()


def silence() -> AbstractContextManager[TextIO]:
    """Keeps viser's own messages off our output."""
    return contextlib.redirect_stdout(io.StringIO())


@contextmanager
def _guarded_by(token: str) -> Iterator[list[str]]:
    """Lets viser listen with our answer before its own; the list is filled when it has."""
    from websockets.asyncio import server as library  # noqa: PLC0415

    listen, guarded = library.serve, []

    def serve(handler: Any, *where: Any, process_request: Any = None, **options: Any) -> Any:
        if handler.__module__.startswith("viser."):
            guarded.append(handler.__module__)
            process_request = _guarding(process_request, token)
        return listen(handler, *where, process_request=process_request, **options)

    library.serve = serve  # type: ignore[assignment, misc]
    try:
        yield guarded
    finally:
        library.serve = listen  # type: ignore[misc]


def _guarding(answer: Answer, token: str) -> Answer:
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
