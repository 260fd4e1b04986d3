# SPDX-License-Identifier: GPL-3.0-or-later
"""Walks Blender's node trees: from an input socket to the node that feeds it, through reroutes, groups and muted nodes.

A place in a tree is a `Ref`: a socket and the group nodes that lead to it, outermost first.
"""
from typing import NamedTuple


class Ref(NamedTuple):
    socket: object
    groups: tuple = ()

    @property
    def node(self):
        return self.socket.node

    def input(self, name):
        """An input of this place's node by identifier or name, or None."""
        return self._enter(find(self.node.inputs, name))

    def inputs(self):
        return [Ref(socket, self.groups) for socket in self.node.inputs if socket.enabled]

    def _enter(self, socket):
        return None if socket is None else Ref(socket, self.groups)


def find(sockets, name):
    """The enabled socket of this identifier, else of this name; nodes hold disabled ones of the same name."""
    for key in ("identifier", "name"):
        for socket in sockets:
            if getattr(socket, key) == name and socket.enabled:
                return socket
    return None


def source(ref):
    """Follows an input. Returns a Ref to the output that feeds it, or to the unlinked input that holds its value."""
    while True:
        if ref.socket.is_output:
            following = _through(ref)
            if following is None:
                return ref
            ref = following
        else:
            links = [link for link in ref.socket.links if link.is_valid and not link.is_muted]
            if not links:
                return ref
            ref = Ref(links[0].from_socket, ref.groups)


def _through(ref):
    """The input that an output merely passes on, or None."""
    node = ref.node
    if node.mute and node.type != "GROUP_INPUT":
        passed = [link.from_socket for link in node.internal_links if link.to_socket == ref.socket]
        return Ref(passed[0], ref.groups) if passed else None
    if node.type == "REROUTE":
        return Ref(node.inputs[0], ref.groups)
    if node.type == "GROUP" and node.node_tree is not None:
        outputs = [n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT"]
        output = next((n for n in outputs if n.is_active_output), None)
        inside = output and find(output.inputs, ref.socket.identifier)
        return Ref(inside, ref.groups + (node,)) if inside else None
    if node.type == "GROUP_INPUT" and ref.groups:
        outside = find(ref.groups[-1].inputs, ref.socket.identifier)
        return Ref(outside, ref.groups[:-1]) if outside else None
    return None


def name(ref):
    """The node's name for a note, with the groups that it is in."""
    return " / ".join([group.name for group in ref.groups] + [ref.node.name])
