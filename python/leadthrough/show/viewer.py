"""Live pages in the browser, served until they are closed."""

from __future__ import annotations

import threading
import webbrowser
from typing import Generic, Literal, TypeVar

from leadthrough import check
from leadthrough.check import ShortRepr
from leadthrough.show.live_session import LiveSession
from leadthrough.show.private import PageServer
from leadthrough.show.replanner import Answer

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
