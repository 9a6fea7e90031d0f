"""Codes of earlier versions; their numbers are not used again."""

from __future__ import annotations

from typing import Final

REMOVED: Final = {
    "0.3": (
        "NRP220",
        "NRP232",
        "NRP233",
        "NRP234",
        "NRP236",
        "NRP242",
        "NRP250",
        "NRP251",
        "NRP295",
        "NRP298",
        "NRP300",
        "NRP304",
        "NRP305",
        "NRP307",
        "NRP309",
        "NRP317",
        "NRP320",
        "NRP323",
        "NRP324",
        "NRP328",
        "NRP331",
        "NRP352",
    ),
}
"""By the version in which they were removed."""

MERGED: Final = {
    "NRP206": "NRP202",
    "NRP214": "NRP200",
    "NRP215": "NRP202",
    "NRP221": "NRP219",
    "NRP222": "NRP210",
    "NRP223": "NRP240",
    "NRP224": "NRP240",
    "NRP225": "NRP240",
    "NRP226": "NRP240",
    "NRP227": "NRP240",
    "NRP228": "NRP240",
    "NRP230": "NRP229",
    "NRP241": "NRP240",
    "NRP244": "NRP239",
    "NRP245": "NRP210",
    "NRP247": "NRP240",
    "NRP252": "NRP240",
    "NRP254": "NRP240",
    "NRP257": "NRP256",
    "NRP259": "NRP258",
    "NRP263": "NRP264",
    "NRP267": "NRP212",
    "NRP268": "NRP212",
    "NRP270": "NRP217",
    "NRP273": "NRP272",
    "NRP274": "NRP272",
    "NRP286": "NRP204",
    "NRP287": "NRP216",
    "NRP293": "NRP292",
    "NRP303": "NRP378",
    "NRP315": "NRP210",
    "NRP316": "NRP306",
    "NRP318": "NRP279",
    "NRP321": "NRP299",
    "NRP326": "NRP376",
    "NRP327": "NRP248",
    "NRP332": "NRP240",
    "NRP336": "NRP279",
    "NRP340": "NRP372",
    "NRP345": "NRP260",
    "NRP346": "NRP266",
    "NRP354": "NRP277",
    "NRP359": "NRP379",
    "NRP360": "NRP380",
    "NRP373": "NRP381",
    "NRP343": "NRP208",
    "NRP344": "NRP208",
    "NRP350": "NRP216",
    "NRP289": "NRP202",
    "NRP351": "NRP202",
    "NRP275": "NRP276",
    "NRP325": "NRP297",
    "NRP322": "NRP248",
    "NRP296": "NRP372",
    "NRP271": "NRP211",
    "NRP302": "NRP243",
    "NRP335": "NRP202",
    "NRP283": "NRP278",
    "NRP261": "NRP260",
    "NRP288": "NRP202",
    "NRP207": "NRP372",
    "NRP281": "NRP280",
    "NRP353": "NRP279",
    "NRP203": "NRP201",
    "NRP290": "NRP377",
}
"""Codes of 0.2 whose findings have another code since 0.3."""


def removed_in(code: str) -> str | None:
    """Return the version in which a code was removed; None if it was not."""
    if code in MERGED:
        return "0.3"
    return next((version for version, codes in REMOVED.items() if code in codes), None)
