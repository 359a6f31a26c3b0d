#!/usr/bin/env python3
"""Runs fiveaxis on sessions and says of each whether the machine may go on.

    python3 examples/automation/judge.py --limit 20 SESSION...

Reads nothing but the JSON that the program prints. Ends with 0 when every machine may go on, 1 when one may not, 2 when a
session could not be judged.
"""

import argparse
import json
import subprocess
import sys


def fiveaxis(program, *arguments):
    """Exit code and JSON of a run; a wrong input is JSON too."""
    run = subprocess.run([program, "--quiet", *arguments, "--json"], capture_output=True, text=True)
    try:
        return run.returncode, json.loads(run.stdout)
    except json.JSONDecodeError:
        sys.exit(f"{program} {' '.join(arguments)} printed no JSON: {run.stderr.strip()}")


def judged(program, session, limit_um):
    """One line about a session, and whether the machine may go on (None: cannot be said)."""
    code, fit = fiveaxis(program, "identify", session)
    if "error" in fit:
        error = fit["error"]
        place = ":".join(str(part) for part in (error["file"], error["line"]) if part)
        return f"{error['kind']}: {place or session}: {error['message']}", None
    if code == 3:
        return f"{fit['verdict']}: {fit['reason']}", None
    large = [
        f"{name} {error['value']:.1f} ± {error['sigma']:.1f} {error['unit']}"
        for name, error in sorted(fit["location_errors"].items())
        if error["determined"] and error["unit"] == "um" and abs(error["value"]) > limit_um
    ]
    unknown = [name for name, error in sorted(fit["location_errors"].items()) if not error["determined"]]
    says = [f"beyond {limit_um:g} um: {', '.join(large)}" if large else f"nothing beyond {limit_um:g} um"]
    if unknown:
        says.append(f"not determined: {', '.join(unknown)}")
    says += [f"warning: {warning}" for warning in fit["warnings"]]
    return "; ".join(says), not large


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sessions", nargs="+", metavar="SESSION")
    parser.add_argument("--program", default="fiveaxis")
    parser.add_argument("--limit", type=float, default=20.0, help="largest position error that is let pass, um")
    options = parser.parse_args()
    verdicts = []
    for session in options.sessions:
        says, may_go_on = judged(options.program, session, options.limit)
        verdicts.append(may_go_on)
        print(f"{session}: {says}")
    return 2 if None in verdicts else int(not all(verdicts))


if __name__ == "__main__":
    sys.exit(main())
