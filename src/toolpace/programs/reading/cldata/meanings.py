"""Statements of cutter-location data without motion, and the cures of those that are refused."""

from __future__ import annotations

ENDS = frozenset(("FINI",))
STOPS = frozenset(
    ("STOP", "OPSTOP", "SPINDL", "COOLNT", "LOADTL", "LOAD", "UNLOAD", "TURRET", "TOOLNO", "CLAMP", "AUXFUN")
)
"""Statements for which a controller comes to rest."""
TOOLS = frozenset(("LOADTL", "LOAD", "TURRET", "TOOLNO"))
"""Those of them that may name another tool."""
PASSED = frozenset(
    (
        "AUTOPS",
        "CLDIST",
        "CLPRNT",
        "CLSF",
        "CSI_SET_EXTENSION_LENGTH",
        "CSI_SET_FLUTE_LENGTH",
        "CUTTER",
        "DISPLY",
        "DRAFT",
        "END",
        "END-OF-PATH",
        "HEAD",
        "INTOL",
        "LEADER",
        "LETTER",
        "LINTOL",
        "LPRINT",
        "MACHIN",
        "MCHFIN",
        "MCHTOL",
        "MODE",
        "MULTAX",
        "NOPOST",
        "OPSKIP",
        "OPTION",
        "OUTTOL",
        "PAINT",
        "PARTNO",
        "PPRINT",
        "PPWORD",
        "PREFUN",
        "PRINT",
        "PSIS",
        "REMARK",
        "REWIND",
        "SELECT",
        "SEQNO",
        "SET",
        "TITLE",
        "TLDATA",
        "TMARK",
        "TOLER",
        "TPRINT",
        "VTLAXS",
    )
)
"""Statements without meaning for motion: counted."""
PASSED_BUT_SAID = {
    "OPSKIP": "OPSKIP: optional statements are run",
    "PREFUN": "PREFUN is taken for a function of the control that moves nothing",
    "SET": "SET is taken for a setting that moves nothing",
}
"""What is taken for granted where some of them stand."""
CANCELLED_BY = frozenset(("OFF", "CANCEL", "NOMORE"))
"""Minor words that make a statement of motion end something, such as CYCLE/OFF."""
CANCELLABLE = frozenset(("CUTCOM", "TRACUT", "COPY", "TRANS", "ROTATE", "ROTABL", "INDEX", "MATRIX", "THICK"))
FRAMES = frozenset(("CSYS", "MATRIX", "ORIGIN", "ROTABL", "ROTATE", "TRACUT", "TRANS", "TRNTYP"))
"""Statements that shift or turn the points after them, unless their numbers say nothing."""

_POINTS = "let the CAM system write GOTO points"
_FRAME = "it moves or turns the points after it: write them where they are, in the workpiece frame"
_CONTOUR = "its motion depends on the shape of the part: write CL data (GOTO points), not the source of APT"
_MACHINE = "its motion is the machine's own: write GOTO or GOHOME with the point"
_PROGRAM = "it decides what is run: let the APT processor run it, and give its CL data"
UNKNOWN = f"it is not known here and might move something: remove it, or {_POINTS}"
CURES = {
    **dict.fromkeys((*FRAMES, "COPY", "INDEX"), _FRAME),
    **dict.fromkeys(("GOFWD", "GOLFT", "GORGT", "GOBACK", "GOUP", "GODOWN", "GO", "TLLFT", "TLRGT", "="), _CONTOUR),
    **dict.fromkeys(("CLEARP", "RETRCT", "PROBE", "AIR"), _MACHINE),
    **dict.fromkeys(("CALSUB", "DEFSUB", "ENDSUB", "JUMPTO", "IF", "CALL", "MACRO", "TERMAC"), _PROGRAM),
    **dict.fromkeys(("MOVARC", "ARC", "HELIX", "FNURBS", "THREAD"), f"its form is not known here: {_POINTS}"),
    "CUTCOM": "the control would shift the tool: give --compensation program where the points are of its centre",
    "INSERT": "it holds code of the control that may move something: write it as statements, or remove it",
    "PPFUN": "what it asks of the post-processor is not known here: remove it where it moves nothing",
    "MODE": "the points after it would be increments: write them as they are, without MODE/INCR",
    "SET": "the points after it would be increments: write them as they are, without SET/MODE,INCR",
    "MSYS": "it changes the coordinates between points: write one program a system",
}


def cure(word: str) -> str:
    """What to do about a refused word; of a word such as TLLFT,GOFWD the first that is known decides."""
    return next((CURES[part] for part in word.split(",") if part in CURES), UNKNOWN)
