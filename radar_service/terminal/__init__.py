"""What commands share at a terminal: arguments, output files, progress, extras that are absent."""

from typing import TYPE_CHECKING

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.terminal.arguments import (
        UsageError, add_sources, add_whole_number, check_sources, did_you_mean, file_ending, number_between, pace,
        thread_count, utc
    )  # fmt: skip
    from radar_service.terminal.extras import MissingExtra, extra
    from radar_service.terminal.html_pages import html_page
    from radar_service.terminal.output_files import (
        NO_ROOM, add_overwrite, make_folder, named_errors, prepare, write_file, written
    )  # fmt: skip
    from radar_service.terminal.progress_bar import progress
else:
    __getattr__, __dir__ = lazily(__name__)
