"""An independent LSP client against the server, with the capabilities of three editors.

Run by ``cargo xtask test``. DOTGEN: the server program. WORKSPACE: the example to work on (a copy is made).
"""

import asyncio
import os
import pathlib
import re
import shutil

import pytest
import pytest_lsp
from lsprotocol import types as t
from pytest_lsp import ClientServerConfig, LanguageClient, client_capabilities

EXAMPLE = pathlib.Path(os.environ["WORKSPACE"]).resolve()
ERROR = t.DiagnosticSeverity.Error
# How to count characters in each position encoding: a codec, and the bytes of its unit.
UNITS = {"utf-8": ("utf-8", 1), "utf-16": ("utf-16-le", 2), "utf-32": ("utf-32-le", 4)}


@pytest.fixture
def workspace(tmp_path):
    return pathlib.Path(shutil.copytree(EXAMPLE, tmp_path / "ws"))


@pytest_lsp.fixture(
    config=ClientServerConfig(server_command=[os.environ["DOTGEN"], "lsp"]),
    params=["visual-studio-code", "neovim", "emacs"],
)
async def client(lsp_client: LanguageClient, request, workspace):
    registrations = answer_requests(lsp_client)
    result = await lsp_client.initialize_session(
        t.InitializeParams(
            capabilities=client_capabilities(request.param),
            root_uri=workspace.as_uri(),
            workspace_folders=[t.WorkspaceFolder(uri=workspace.as_uri(), name="ws")],
        )
    )
    lsp_client.offers = result.capabilities
    lsp_client.registrations = registrations
    yield
    await lsp_client.shutdown_session()


def answer_requests(client: LanguageClient) -> list[t.Registration]:
    """Answers what a server may ask of the editors played here, and pytest-lsp does not. Returns what it registers."""
    registrations = []

    @client.feature(t.CLIENT_REGISTER_CAPABILITY)
    def register(params: t.RegistrationParams):
        registrations.extend(params.registrations)

    for refresh in (
        t.WORKSPACE_SEMANTIC_TOKENS_REFRESH,
        t.WORKSPACE_CODE_LENS_REFRESH,
        t.WORKSPACE_INLAY_HINT_REFRESH,
    ):
        client.feature(refresh)(lambda *_: None)

    return registrations


class Document:
    """An open document: what an editor knows of it."""

    def __init__(self, client: LanguageClient, path: pathlib.Path):
        self.client = client
        self.uri = path.as_uri()
        self.text = path.read_text()
        self.version = 1
        client.text_document_did_open(
            t.DidOpenTextDocumentParams(
                text_document=t.TextDocumentItem(
                    uri=self.uri, language_id="genom3", version=1, text=self.text
                )
            )
        )

    @property
    def id(self):
        return t.TextDocumentIdentifier(uri=self.uri)

    def position(self, needle: str, offset: int = 0) -> t.Position:
        """Where `needle` first stands, `offset` characters further."""
        before = self.text[: self.text.index(needle) + offset]
        line = before.rsplit("\n", 1)[-1]
        codec, unit = UNITS[self.client.offers.position_encoding or "utf-16"]
        return t.Position(
            line=before.count("\n"), character=len(line.encode(codec)) // unit
        )

    def replace(self, old: str, new: str):
        """Sends an incremental change."""
        start, end = self.position(old), self.position(old, len(old))
        self.text = self.text.replace(old, new, 1)
        self.version += 1
        self.client.text_document_did_change(
            t.DidChangeTextDocumentParams(
                text_document=t.VersionedTextDocumentIdentifier(
                    uri=self.uri, version=self.version
                ),
                content_changes=[
                    t.TextDocumentContentChangePartial(
                        range=t.Range(start=start, end=end), text=new
                    )
                ],
            )
        )

    async def errors(self) -> list[t.Diagnostic]:
        """The errors of the current version, pushed or asked for as the server offers."""
        if self.client.offers.diagnostic_provider is not None:
            report = await self.client.text_document_diagnostic_async(
                t.DocumentDiagnosticParams(text_document=self.id)
            )
            found = report.items
        else:
            found = self.client.diagnostics.get(self.uri, [])
        return [d for d in found if d.severity == ERROR]

    async def wait_for_errors(self, wanted) -> list[t.Diagnostic]:
        """Waits for pushed diagnostics until `wanted` accepts the errors."""
        while True:
            errors = await self.errors()
            if wanted(errors):
                return errors
            await asyncio.wait_for(
                self.client.wait_for_notification(t.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS),
                timeout=20,
            )


@pytest.mark.asyncio
async def test_error_appears_and_vanishes(client: LanguageClient, workspace):
    document = Document(client, workspace / "maneuver.gen")
    document.replace("yield ether wcet 4 us;", "yield ether wcet 4 us; oops")
    [error, *_] = await document.wait_for_errors(lambda errors: errors)
    assert error.source == "dotgen"
    assert error.code
    assert error.range.start.line in range(
        document.position("oops").line, document.position("oops").line + 2
    )
    document.replace(" oops", "")
    await document.wait_for_errors(lambda errors: not errors)


@pytest.mark.asyncio
async def test_positions_count_in_the_negotiated_unit(client: LanguageClient, workspace):
    document = Document(client, workspace / "maneuver.gen")
    # Four, two or one unit each: a server that counts otherwise places the edit wrongly and sees an error.
    document.replace("  period 5 ms;", "  /* \U0001f681\U0001f681 */ period 5 ms;")
    document.replace("period 5 ms;", "period 10 ms; oops")
    await document.wait_for_errors(lambda errors: errors)
    document.replace(" oops", "")
    await document.wait_for_errors(lambda errors: not errors)


@pytest.mark.asyncio
async def test_document_symbols(client: LanguageClient, workspace):
    document = Document(client, workspace / "maneuver.gen")
    symbols = await client.text_document_document_symbol_async(
        t.DocumentSymbolParams(text_document=document.id)
    )

    def names(symbols):
        for symbol in symbols or []:
            yield symbol.name
            yield from names(getattr(symbol, "children", None))

    assert {"maneuver", "plan", "exec", "goto", "waypoint"} <= set(names(symbols))


@pytest.mark.asyncio
async def test_definition_of_an_include(client: LanguageClient, workspace):
    document = Document(client, workspace / "maneuver.gen")
    found = await client.text_document_definition_async(
        t.DefinitionParams(
            text_document=document.id,
            position=document.position("or/pose/pose_estimator.gen", 4),
        )
    )
    [target] = found if isinstance(found, list) else [found]
    uri = getattr(target, "uri", None) or target.target_uri
    assert uri == (workspace / "idl/or/pose/pose_estimator.gen").as_uri()


@pytest.mark.asyncio
async def test_semantic_tokens_are_in_order(client: LanguageClient, workspace):
    document = Document(client, workspace / "maneuver.gen")
    tokens = await client.text_document_semantic_tokens_full_async(
        t.SemanticTokensParams(text_document=document.id)
    )
    lines = document.text.split("\n")
    line = start = end = 0
    count = 0
    for i in range(0, len(tokens.data), 5):
        delta_line, delta_start, length, _type, _modifiers = tokens.data[i : i + 5]
        line += delta_line
        start = delta_start if delta_line else start + delta_start
        assert delta_line or start >= end, "tokens overlap"
        end = start + length
        assert length > 0 and end <= len(lines[line])
        count += 1
    assert count > 100


@pytest.mark.asyncio
async def test_folding_and_selection(client: LanguageClient, workspace):
    document = Document(client, workspace / "maneuver.gen")
    folds = await client.text_document_folding_range_async(
        t.FoldingRangeParams(text_document=document.id)
    )
    component = document.position("component maneuver").line
    assert any(fold.start_line == component for fold in folds)
    [selection] = await client.text_document_selection_range_async(
        t.SelectionRangeParams(
            text_document=document.id, positions=[document.position("mv_exec_wait", 3)]
        )
    )
    sizes = []
    while selection is not None:
        r = selection.range
        sizes.append((r.end.line - r.start.line, r.end.character - r.start.character))
        selection = selection.parent
    assert len(sizes) > 3, "from the name to the whole file"


@pytest.mark.asyncio
async def test_file_of_its_own(client: LanguageClient, tmp_path):
    """A file outside the workspace folders is served as well."""
    path = tmp_path / "alone.gen"
    path.write_text("component alone { task t { period 1 ms; } };\n")
    document = Document(client, path)
    await document.wait_for_errors(lambda errors: errors)  # a `;` is missing
    document.replace("} };", "}; };")
    await document.wait_for_errors(lambda errors: not errors)


@pytest.mark.asyncio
async def test_definition_and_references_of_a_type_in_another_file(
    client: LanguageClient, workspace
):
    document = Document(client, workspace / "maneuver.gen")
    inside = document.position("or_pose_estimator::state state", len("or_pose_estimator::st"))
    found = await client.text_document_definition_async(
        t.DefinitionParams(text_document=document.id, position=inside)
    )
    [target] = found if isinstance(found, list) else [found]
    uri = getattr(target, "uri", None) or target.target_uri
    assert uri.startswith((workspace / "idl/or/pose").as_uri())
    references = await client.text_document_references_async(
        t.ReferenceParams(
            text_document=document.id,
            position=inside,
            context=t.ReferenceContext(include_declaration=True),
        )
    )
    used = document.text.count("or_pose_estimator::state")
    here = [it for it in references if it.uri == document.uri]
    assert len(here) == used and len(references) > used, "and the declaration, elsewhere"


@pytest.mark.asyncio
async def test_rename_of_a_state_and_back(client: LanguageClient, workspace):
    document = Document(client, workspace / "maneuver.gen")
    before = document.text

    async def rename(at: t.Position, name: str):
        edit = await client.text_document_rename_async(
            t.RenameParams(text_document=document.id, position=at, new_name=name)
        )
        edits = edit.changes or {}
        for change in edit.document_changes or []:
            edits.setdefault(change.text_document.uri, []).extend(change.edits)
        assert list(edits) == [document.uri]
        codec, unit = UNITS[client.offers.position_encoding or "utf-16"]
        lines = document.text.split("\n")

        def offset(position: t.Position) -> int:
            line = lines[position.line].encode(codec)[: position.character * unit]
            return sum(len(it) + 1 for it in lines[: position.line]) + len(line.decode(codec))

        text = document.text
        for it in sorted(edits[document.uri], key=lambda it: -offset(it.range.start)):
            text = text[: offset(it.range.start)] + it.new_text + text[offset(it.range.end) :]
        document.replace(document.text, text)

    await rename(document.position("codel<wait> mv_exec_wait", 7), "idle")
    assert "yield pause::idle, main wcet 1165 us" in document.text
    assert "codel<idle> mv_exec_wait" in document.text
    # A state is one event of the component, whichever machines it is in.
    assert "codel<idle> mv_plan_exec_wait" in document.text
    await document.wait_for_errors(lambda errors: not errors)
    await rename(document.position("codel<idle> mv_exec_wait", 7), "wait")
    assert document.text == before


@pytest.mark.asyncio
async def test_the_page_of_editors_lists_the_commands_of_the_server(client):
    page = (pathlib.Path(__file__).resolve().parents[3] / "docs/editors.md").read_text()
    table = page[page.index("| command | argument |") : page.index("## Settings of the client")]
    rows = [row.split("|")[1] for row in table.splitlines() if row.startswith("| `")]
    listed = [name for row in rows for name in re.findall(r"`([^`]+)`", row)]
    assert sorted(listed) == sorted(client.offers.execute_command_provider.commands)
