"""The panels of the page: each gets what it asks for, and nothing else; a new one is a file and a line in the list."""

import json

from tests.clients.chromium import Page
from tests.clients.screen import BROWSER

pytestmark = BROWSER

KINDS = ["status", "controls", "scene", "commands", "errors"]
GIVEN = """import('./panels.js').then(({Panels}) => {
  const told = [], place = document.createElement('p'), column = document.createElement('div');
  column.append(place);
  const element = Object.assign(document.createElement('b'), {id: 'new'});
  const panels = new Panels([
    {element, changes: ['errors'], changed: ({kind}) => told.push(['one', kind]), hello: ({epoch}) => told.push(['one', epoch])},
    {changes: ['controls', 'status'], changed: ({kind}) => told.push(['two', kind])},
    {hello: ({epoch}) => told.push(['three', epoch]), second: () => told.push(['three', 'second'])},
  ], place);
  SCRIPT
})"""


def test_a_panel_gets_the_changes_that_it_wants(modules: Page) -> None:
    script = f"for (const kind of {json.dumps(KINDS)}) panels.changed({{kind}}); return told;"
    assert modules.ask(GIVEN.replace("SCRIPT", script)) == [["two", "status"], ["two", "controls"], ["one", "errors"]]


def test_a_panel_is_told_what_it_has_a_function_for(modules: Page) -> None:
    script = "panels.tell('hello', {epoch: 'a'}); panels.tell('second'); panels.tell('forget'); return told;"
    assert modules.ask(GIVEN.replace("SCRIPT", script)) == [["one", "a"], ["three", "a"], ["three", "second"]]


def test_elements_of_panels_stand_in_the_column(modules: Page) -> None:
    assert modules.ask(
        GIVEN.replace("SCRIPT", "return [...column.children].map(({id, localName}) => id || localName);")
    ) == [
        "new",
        "p",
    ]
