"""Comparison of engines: each gets the inputs of another one; output differences have margins.

::

    reference run ──recorded brain──> another world ──signals──┐
                  ──recorded world──> another brain ──signals──┴──measures──> verdict <── margins, baseline
"""
