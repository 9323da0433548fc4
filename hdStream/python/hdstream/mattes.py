# SPDX-License-Identifier: Apache-2.0
"""Headers of Cryptomattes whose pixels were rendered apart (docs/film.md)."""

import json

_MANIFEST = "/manifest"


def JoinHeaders(headers):
    """Of the parts of an image: {layer: {entry: text}}; a manifest names what any part shows, in the order of names."""
    joined = {}
    for header in headers:
        for layer, entries in header.items():
            own = joined.setdefault(layer, {})
            for name, text in entries.items():
                own[name] = _JoinManifests(own.get(name, "{}"), text) if name.endswith(_MANIFEST) else text
    return joined


def _JoinManifests(a, b):
    names = {**json.loads(a), **json.loads(b)}
    # As the core writes them: by the bytes of the names, without spaces, UTF-8 as it is.
    ordered = dict(sorted(names.items(), key=lambda entry: entry[0].encode("utf-8", "surrogatepass")))
    return json.dumps(ordered, separators=(",", ":"), ensure_ascii=False)
