"""Data sets go to the hub and come back, by its own library, through a stand-in of the hub.

The stand-in speaks as much of the hub's HTTP interface as that takes, and keeps one repository.
"""

import base64
import hashlib
import json
import shutil
import sys
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import pytest

from pigbench import cli
from pigbench.data import dataset
from pigbench.errors import UserError
from pigbench.support import files

constants = pytest.importorskip("huggingface_hub.constants")

NAME = "someone/cube-single"
COMMIT = "c0ffee" + "0" * 34


class Hub(ThreadingHTTPServer):
    """A hub on this machine."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Answers)
        self.url = f"http://127.0.0.1:{self.server_address[1]}"
        self.made: list[dict] = []
        self.objects: dict[str, bytes] = {}  # large files, by SHA-256
        self.files: dict[str, bytes] = {}  # of the repository, by path
        self.sent: list[str] = []  # large files that were uploaded


class Answers(BaseHTTPRequestHandler):
    server: Hub

    def log_message(self, *_) -> None:
        pass

    def do_POST(self) -> None:
        body = self._body()
        if self.headers["Authorization"] != "Bearer hf_secret":
            self._answer(401, {"error": "Invalid credentials"})
        elif self.path == "/api/repos/create":
            self.server.made.append(json.loads(body))
            self._answer(200, {"url": f"{self.server.url}/datasets/{NAME}"})
        elif self.path == "/api/validate-yaml":
            self._answer(200, {"errors": [], "warnings": []})
        elif self.path == f"/api/datasets/{NAME}/preupload/main":
            asked = json.loads(body)["files"]
            modes = [
                {
                    "path": file["path"],
                    "uploadMode": "lfs" if file["path"].endswith(".npy") else "regular",
                    "shouldIgnore": False,
                }
                for file in asked
            ]
            self._answer(200, {"files": modes})
        elif self.path == f"/datasets/{NAME}.git/info/lfs/objects/batch":
            self._answer(200, {"objects": [self._place(o) for o in json.loads(body)["objects"]]})
        elif self.path == f"/api/datasets/{NAME}/commit/main":
            for line in map(json.loads, body.splitlines()):
                self._keep(line["key"], line["value"])
            self._answer(
                200,
                {
                    "success": True,
                    "commitOid": COMMIT,
                    "commitUrl": f"{self.server.url}/datasets/{NAME}/commit/{COMMIT}",
                },
            )
        else:
            self._answer(404, {"error": self.path})

    def do_PUT(self) -> None:
        content = self._body()
        name = self.path.rpartition("/")[2]
        assert hashlib.sha256(content).hexdigest() == name
        self.server.objects[name] = content
        self.server.sent.append(name)
        self._answer(200, {})

    def do_GET(self) -> None:
        path = self.path.partition("?")[0]
        if path in (f"/api/datasets/{NAME}", f"/api/datasets/{NAME}/revision/main"):
            self._answer(200, {"_id": "1", "id": NAME, "sha": COMMIT, "siblings": []})
        elif path.startswith(f"/api/datasets/{NAME}/tree/"):
            self._answer(
                200,
                [
                    {"type": "file", "path": path, "size": len(content), "oid": _name(content)}
                    for path, content in self.server.files.items()
                ],
            )
        elif path.startswith(f"/datasets/{NAME}/resolve/"):
            self._send_file(path.split("/", 6)[6])
        else:
            self._answer(404, {"error": "Repository not found"}, {"X-Error-Code": "RepoNotFound"})

    def do_HEAD(self) -> None:
        self.do_GET()

    def _place(self, asked: dict) -> dict:
        there = asked["oid"] in self.server.objects
        action = {"upload": {"href": f"{self.server.url}/lfs/{asked['oid']}"}}
        return asked | ({} if there else {"actions": action})

    def _keep(self, kind: str, value: dict) -> None:
        if kind == "file":
            self.server.files[value["path"]] = base64.b64decode(value["content"])
        elif kind == "lfsFile":
            self.server.files[value["path"]] = self.server.objects[value["oid"]]

    def _send_file(self, path: str) -> None:
        content = self.server.files[path]
        headers = {"ETag": f'"{_name(content)}"', "X-Repo-Commit": COMMIT}
        self._send(200, content, headers)

    def _body(self) -> bytes:
        if self.headers.get("Transfer-Encoding") != "chunked":
            return self.rfile.read(int(self.headers["Content-Length"]))
        body = b""
        while size := int(self.rfile.readline(), 16):
            body += self.rfile.read(size)
            self.rfile.readline()
        self.rfile.readline()
        return body

    def _answer(self, status: int, content: object, headers: dict[str, str] | None = None) -> None:
        kind = {"Content-Type": "application/json"}
        self._send(status, json.dumps(content).encode(), kind | (headers or {}))

    def _send(self, status: int, content: bytes, headers: dict[str, str]) -> None:
        self.send_response(status)
        for name, value in (headers | {"Content-Length": str(len(content))}).items():
            self.send_header(name, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)


def _name(content: bytes) -> str:
    return hashlib.sha1(content).hexdigest()


@pytest.fixture
def server(monkeypatch) -> Iterator[Hub]:
    with Hub() as server:
        Thread(target=server.serve_forever, daemon=True).start()
        # As HF_ENDPOINT does where it is set before the library is imported.
        template = constants.HUGGINGFACE_CO_URL_TEMPLATE.replace(constants.ENDPOINT, server.url)
        monkeypatch.setattr(constants, "HUGGINGFACE_CO_URL_TEMPLATE", template)
        monkeypatch.setattr(constants, "ENDPOINT", server.url)
        monkeypatch.setattr(constants, "HF_HUB_DISABLE_XET", True)
        monkeypatch.setenv("HF_TOKEN", "hf_secret")
        yield server
        server.shutdown()


def push(data: Path, *more: str) -> None:
    cli.run(["data", "push", NAME, "--data", str(data), *more])


def pull(out: Path) -> None:
    cli.run(["data", "pull", NAME, "--out", str(out)])


def test_a_data_set_goes_there_and_comes_back(server, data, tmp_path, capsys):
    (data / "notes.txt").write_text("mine alone")
    push(data, "--private", "--license", "cc-by-4.0")
    assert f"{data} is at {server.url}/datasets/{NAME}" in capsys.readouterr().out
    (made,) = server.made
    assert made["type"] == "dataset"
    assert made.get("private") or made.get("visibility") == "private"
    pull(tmp_path / "back")
    theirs, ours = dataset.load(tmp_path / "back"), dataset.load(data)
    assert theirs.digest == ours.digest
    assert {path for path in server.files if not path.endswith(".npy")} == {
        "manifest.json",
        "README.md",
    }
    assert server.files["README.md"] == (data / "README.md").read_bytes()
    assert b"cc-by-4.0" in server.files["README.md"]


def test_what_is_there_is_not_sent_again(server, data):
    push(data)
    first = list(server.sent)
    assert set(first) == {files.sha256(path) for path in data.glob("*/*.npy")}
    push(data)
    assert server.sent == first


def test_a_file_that_is_not_the_manifests_is_found(server, data, tmp_path):
    push(data)
    torn = bytearray(server.files["train-00001/actions.npy"])
    torn[-1] ^= 1
    server.files["train-00001/actions.npy"] = bytes(torn)
    with pytest.raises(UserError, match=r"complete data set: .*train-00001/actions.npy is altered"):
        pull(tmp_path / "back")


def test_what_the_hub_refuses_is_one_line(server, data, tmp_path, monkeypatch):
    with pytest.raises(UserError, match="no/such/name cannot be pulled"):
        cli.run(["data", "pull", "no/such/name", "--out", str(tmp_path / "new")])
    with pytest.raises(UserError, match="someone/else cannot be pulled"):
        cli.run(["data", "pull", "someone/else", "--out", str(tmp_path / "new")])
    assert not (tmp_path / "new").exists()
    monkeypatch.setenv("HF_TOKEN", "hf_wrong")
    with pytest.raises(UserError, match=f"{NAME} cannot be pushed to: .*401") as refused:
        push(data)
    assert "\n" not in str(refused.value)
    server.shutdown()
    server.server_close()
    with pytest.raises(UserError, match=f"{NAME} cannot be pulled"):
        pull(tmp_path / "other")


def test_a_folder_of_something_else_is_left_alone(server, data, tmp_path):
    shutil.copytree(data, tmp_path / "own")
    with pytest.raises(UserError, match="is not an empty folder"):
        pull(tmp_path / "own")


def test_without_the_library_it_is_named(data, monkeypatch):
    monkeypatch.setitem(sys.modules, "huggingface_hub", None)
    with pytest.raises(UserError, match=r"needs the package huggingface_hub.*pigbench\[share\]"):
        push(data)
