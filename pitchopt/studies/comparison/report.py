"""The comparison as one HTML page that needs no network."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import pitchopt
from pitchopt.exports.html import (
    html_list,
    html_page,
    html_paragraph,
    html_picture,
    html_section,
    html_table,
)
from pitchopt.studies.comparison.document import PLANNED
from pitchopt.studies.comparison.tables import (
    change_rows,
    effort_rows,
    few_seeds,
    knowledge_rows,
    load_rows,
    point_rows,
    promise,
    wind_title,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["comparison_report"]

_CAPTIONS = {
    "changes": "Change of the 1 Hz damage-equivalent loads against the collective controller in "
    "the same "
    "winds, with 95 % confidence intervals of the mean over seeds.",
    "intensity": "The same over the turbulence intensity. Each method is prepared in the wind "
    "that it is "
    "judged in, but for the feed-forward design, which is that of the steady wind.",
    "turns": "Two turns of the rotor: pitch of blade 1 less the mean of the blades, and its "
    "root moment.",
}


def comparison_report(
    document: Mapping[str, Any], figures: Mapping[str, Figure], *, command: str = ""
) -> str:
    """HTML page.

    Parameters
    ----------
    document : mapping
        Of `comparison_document`.
    figures : mapping of str to Figure
        Of `pitchopt.plotting.method_figures`.
    command : str
        That the comparison was made with.
    """
    settings = document["settings"]["comparison"]
    title = f"Pitch control compared: {document['case']}, {document['wind_speed']:g} m/s"
    body = [
        html_paragraph(
            f"Turbine {document['turbine']} at {document['rotor_speed_rpm']:.2f} rpm, free rotor "
            "under its baseline controller, bending blades and tower, pitch actuators with a lag "
            f"of {settings['pitch_lag']:g} s. Each run counts {settings['duration']:g} s after "
            f"{settings['skip']:g} s of start-up. Tuners had at most {settings['evaluations']} "
            f"evaluations each (seeds in turbulence: {settings['tuning_seeds']}); their cost is "
            "the fatigue of the blade roots out of plane."
        )
    ]
    for method in PLANNED:
        found = document["verdict"].get(method)
        if found is not None and found["sentences"]:
            body += [
                html_section(f"Where the {method} profile pays"),
                html_list(found["sentences"]),
            ]
    added = document["verdict"]["added_to_individual_pitch"]
    if added:
        body += [
            html_section("What the profile adds to individual pitch"),
            html_paragraph("Changes of feed-forward+ipc against ipc-bayes in the same winds:"),
            html_list(added),
        ]
    body += [html_paragraph(text) for text in (promise(document), few_seeds(document)) if text]
    body.append(
        html_paragraph(
            "It pays where the 95 % confidence interval of the cut of a damage-equivalent load "
            f"lies above {100 * document['verdict']['worth']:g} %, and is lost in the scatter "
            "where the interval is too wide to tell."
        )
    )
    for name, figure in figures.items():
        body.append(html_picture(_svg(figure), _CAPTIONS[name]))
    for one in document["winds"]:
        wind = one["wind"]
        body += [
            html_section(wind_title(document, wind)),
            html_section("Change of damage-equivalent loads", level=3),
            html_table(change_rows(document, wind), header=2),
            html_section("Change of RMS", level=3),
            html_table(change_rows(document, wind, "rms"), header=2),
            html_section("RMS and damage-equivalent loads", level=3),
            html_table(load_rows(document, wind), header=2),
        ]
    messages = [
        f"{one['method']} in {one['wind']}: {one['status']}: {one['message']}"
        for one in document["entries"]
        if one["message"]
    ]
    if messages:
        body += [html_section("Not judged"), html_list(messages)]
    body += [
        html_section("What each had to know"),
        html_table(knowledge_rows(document), left=5),
        html_section("What each took"),
        html_table(effort_rows(document), left=2),
    ]
    points = point_rows(document)
    if len(points) > 2:
        body += [
            html_section("What the tuners chose"),
            html_table(points, header=2, left=2),
        ]
    if command:
        body += [html_section("Made with"), html_paragraph(command, code=True)]
    body.append(
        html_paragraph(f"pitchopt {pitchopt.__version__}, {document['seconds']:.0f} s in all")
    )
    return html_page(title, body)


def _svg(figure: Figure) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()
