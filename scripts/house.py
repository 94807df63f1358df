#!/usr/bin/env python3
"""python3 scripts/house.py [FOLDER…]
How large the library is: one column for each checkout, this one if none is given. `git worktree add` makes one of an older version.

headers, lines    all files *.hpp below include/, everything counted
rooms             folders right below include/phistep; arrows: pairs of rooms of which one includes the other
folders, floors   all folders with headers; the floors that tests/floors/check_floors.cmake gives them
circles           first-level rooms that include each other, directly or through others
guesses           `if constexpr (requires …)`: a capability that is guessed instead of declared
symbols           what ctags reads, so what an editor finds (universal-ctags; - without it)"""
import os
import re
import shutil
import subprocess
import sys


def measure(root):
    base = os.path.join(root, 'include', 'phistep')
    texts = {}
    for folder, _, names in os.walk(base):
        for name in names:
            if name.endswith('.hpp'):
                path = os.path.join(folder, name)
                texts[os.path.relpath(path, base)] = open(path, encoding='utf-8').read()
    lines = {path: text.count('\n') for path, text in texts.items()}
    room = {path: path.split('/')[0] for path in texts}
    rooms = {r for path, r in room.items() if '/' in path}
    arrows = {(room[path], room[target]) for path, text in texts.items()
              for target in re.findall(r'^[ \t]*#[ \t]*include[ \t]*["<]phistep/([^">]+)', text, re.M)
              if '/' in path and '/' in target and target in room and room[path] != room[target]}
    reached = {r: {b for a, b in arrows if a == r} for r in rooms}
    for _ in rooms:
        for r in rooms:
            reached[r] |= {c for b in reached[r] for c in reached[b]}
    floors = re.findall(r'^set\(floor_of_\S+ (\d+)\)', open(os.path.join(root, 'tests/floors/check_floors.cmake')).read(), re.M)
    code = '\n'.join(texts.values())
    longest = max(lines, key=lines.get)
    pages = subprocess.run(['git', '-C', root, 'ls-files', '*.md'], capture_output=True, text=True, check=True).stdout.split()
    tags = None
    if shutil.which('ctags'):
        done = subprocess.run(['ctags', '-R', '--languages=C++', '-f', '-', base], capture_output=True, check=True)
        tags = done.stdout.count(b'\n')
    return {
        'headers': len(texts), 'lines': sum(lines.values()), 'rooms': len(rooms), 'arrows between rooms': len(arrows),
        'folders': len({os.path.dirname(p) for p in texts if '/' in p}), 'floors': len(set(floors)),
        'rooms in circles': sum(r in reached[r] for r in rooms),
        'if constexpr': code.count('if constexpr'), 'guesses': len(re.findall(r'if constexpr \(\s*requires', code)),
        'headers past 250 lines': sum(n > 250 for n in lines.values()), 'longest file': f'{lines[longest]} {longest}',
        'symbols by ctags': tags if tags is not None else '-',
        'words of Markdown': sum(len(open(os.path.join(root, p), encoding='utf-8').read().split()) for p in pages),
    }


def main():
    if any(a.startswith('-') for a in sys.argv[1:]):
        sys.exit(__doc__)
    houses = [measure(root) for root in sys.argv[1:] or [os.path.join(os.path.dirname(os.path.abspath(__file__)), '..')]]
    for key in houses[0]:
        print(f'{key:24}' + ''.join(f'{str(h[key]):>32}' for h in houses))


main()
