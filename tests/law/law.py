#!/usr/bin/env python3
"""Checks one law of the house and prints what breaks it; exit status 1 if anything does.

law.py --root ROOT arrows | libraries | public_headers | order | scratch | documents | counts | test_names
law.py --root ROOT compiled BUILD
law.py loaded PROGRAM...
"""

import argparse
import sys
from pathlib import Path

import built
import counts
import documents
import sources

TEXT_LAWS = {
    "arrows": sources.check_arrows,
    "libraries": sources.check_libraries,
    "public_headers": sources.check_public_headers,
    "order": sources.check_order,
    "scratch": sources.check_scratch,
    "documents": documents.check_documents,
    "counts": counts.check_counts,
    "test_names": sources.check_test_names,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", default=Path(__file__).resolve().parents[2], type=Path)
    parser.add_argument("law", choices=[*TEXT_LAWS, "compiled", "loaded"])
    parser.add_argument("target", nargs="*", help="build folder, or programs")
    arguments = parser.parse_args()

    if arguments.law in TEXT_LAWS:
        if not any(sources.rooms(arguments.root)):
            parser.error(f"{arguments.root} has no rooms")
        broken = list(TEXT_LAWS[arguments.law](arguments.root))
    elif not arguments.target:
        parser.error(f"{arguments.law} needs something to look at")
    elif arguments.law == "compiled":
        broken = [line for build in arguments.target
                  for line in built.check_compiled(arguments.root, build)]
    else:
        broken = list(built.check_programs(arguments.target))

    for line in broken:
        print(line)
    print(f"{arguments.law}: {len(broken)} broken" if broken else f"{arguments.law}: kept")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
