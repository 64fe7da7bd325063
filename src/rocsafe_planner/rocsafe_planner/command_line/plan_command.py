# SPDX-License-Identifier: Apache-2.0
"""`plan_file`: plan without ROS. One JSON request on standard input, one JSON summary out.

The request is described in `request_json`. If it names an `output_directory`, the plan's files are
written there and listed in the summary. Exit code 0; 2 with one line on standard error if the
request is wrong or has no plan.
"""

import argparse
import json
import sys
from collections.abc import Sequence

from rocsafe_planner.command_line import request_json
from rocsafe_planner.errors import PlannerError
from rocsafe_planner.export.plan_files import write_plan
from rocsafe_planner.export.plan_json import quality_document
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.site.document import Document

EXIT_OK = 0
EXIT_REFUSED = 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Read, plan, write, and return the exit code."""
    argparse.ArgumentParser(
        prog='plan_file',
        description='Plan a survey: reads one JSON request from standard input, prints a summary.',
        epilog=request_json.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    ).parse_args(arguments)
    try:
        text = _plan(sys.stdin.buffer.read())
    except (PlannerError, ValueError) as error:
        sys.stderr.write(f'error: {error}\n')
        return EXIT_REFUSED
    sys.stdout.write(text + '\n')
    return EXIT_OK


def _plan(content: bytes) -> str:
    request = request_json.parse_request(content.decode('utf-8', errors='replace'))
    plan = plan_survey(request.survey_request())
    return json.dumps(summary(plan, request.output_directory), indent=1)


def summary(plan: SurveyPlan, output_directory: str) -> Document:
    """Return the figures of a plan; write its files, if there is a folder for them."""
    files = write_plan(plan, output_directory) if output_directory else []
    return {**quality_document(plan), 'files': [str(path) for path in files]}


if __name__ == '__main__':
    raise SystemExit(main())
