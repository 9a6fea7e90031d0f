"""Does a finding depend on the simulator? A grid of brains, worlds and seeds is run, measured and judged.

::

    grid ──runs──> recordings ──signals──> metrics ──statistics──> judgement ──> report
                       └──────divergence: where two of them first differ ────────┘
"""
