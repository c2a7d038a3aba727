"""The live page answers to whoever knows its address, and to no other page or program."""

import asyncio
import http.client
from concurrent.futures import ThreadPoolExecutor
from urllib.parse import urlsplit

import pytest

pytest.importorskip("websockets", reason="websockets is not installed")
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from leadthrough.show.live_session import PageServer


class Greeting:
    """A session that greets whoever opens the page."""

    def greeting(self):
        return ["hello"]

    def hear(self, message):
        pass

    def advance(self, _):
        return []

    def left(self):
        pass


def served():
    return PageServer("<html>page</html>", Greeting(), port=0, period=0.02)


@pytest.fixture(scope="module")
def private():
    server = served()
    yield server
    server.close()


def answer(private, path, **headers):
    address = urlsplit(private.url)
    connection = http.client.HTTPConnection(address.hostname, address.port, timeout=20)
    connection.request("GET", path, headers=headers)
    response = connection.getresponse()
    content = response.read()
    connection.close()
    return response.status, content, response.headers


def opens(private, url, **options):
    async def opened():
        async with connect(f"{url}live", proxy=None, **options) as socket:
            return bool(await asyncio.wait_for(socket.recv(), 20))

    # A browser test of the same process may have left an event loop running in this thread.
    try:
        with ThreadPoolExecutor(1) as thread:
            return thread.submit(lambda: asyncio.run(opened())).result()
    except InvalidStatus as error:
        assert error.response.status_code == 403
        return False


def test_the_address_with_its_token_shows_the_page(private):
    status, content, headers = answer(private, urlsplit(private.url).path)
    assert status == 200
    assert b"<html" in content[:2000].lower()
    assert headers["Referrer-Policy"] == "no-referrer"
    assert len(urlsplit(private.url).path) > 30


@pytest.mark.parametrize("path", ["/", "/index.html", "/wrong/", "/wrong/index.html", "/%00/"])
def test_without_the_token_nothing_is_shown(private, path):
    status, content, _ = answer(private, path)
    assert (status, content) == (403, b"Open the address that leadthrough printed, with all of its"
                                      b" letters.\n")  # fmt: skip


@pytest.mark.parametrize("host", ["evil.example", "evil.example:{port}", "127.0.0.1", ""])
def test_a_name_that_is_made_to_point_here_is_refused(private, host):
    address = urlsplit(private.url)
    named = host.format(port=address.port)
    assert answer(private, address.path, Host=named)[0] == 403
    assert answer(private, address.path, Host=f"localhost:{address.port}")[0] == 200


def test_other_pages_cannot_open_the_socket(private):
    address = urlsplit(private.url)
    here = f"ws://{address.netloc}"
    own = f"http://{address.netloc}"
    assert opens(private, here + address.path, origin=own)
    assert opens(private, here + address.path)  # a program, which was told the address
    for origin in ("http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1"):
        assert not opens(private, here + address.path, origin=origin)
    assert not opens(private, f"{here}/", origin=own)
    assert not opens(private, f"{here}/wrong/", origin=own)


def test_each_server_has_a_token_of_its_own(private):
    other = served()
    try:
        assert urlsplit(other.url).path != urlsplit(private.url).path
        assert answer(other, urlsplit(private.url).path)[0] == 403
    finally:
        other.close()
