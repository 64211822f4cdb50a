"""Templates escape what fills them, and say what they were not given."""

import pytest
from jinja2 import UndefinedError

from radar_service.terminal.html_pages import html_page

STUDY = {"scenario": "s & <s>", "source": "", "series": [{"environment": '"', "targets": []}]}


def test_what_fills_a_page_is_escaped() -> None:
    values = {"criterion": lambda study: "<b>", "figure": lambda series: ""}
    page = html_page("bench/detection/report.html", study=STUDY, **values)
    assert page.count("s &amp; &lt;s&gt;") == 2 and "<h2>&#34;</h2>" in page and "<p>&lt;b&gt;" in page
    assert "pip install &#39;.[pictures]&#39;" in page


def test_a_value_that_a_template_lacks_is_an_error() -> None:
    with pytest.raises(UndefinedError, match="criterion"):
        html_page("bench/detection/report.html", study=STUDY)
