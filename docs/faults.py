"""The record of faults, `results/reference/faults.json`, as the tables of the page on them."""

FAULTS = {
    "killed": "`kill -9` at a random moment of a run, then resumed",
    "interrupted": "Ctrl-C at a random moment of a run, then resumed",
    "full_disk": "the disk full, at sizes from 4 to 32 KiB, then room made and resumed",
    "read_only": "the results read-only: a new run, a resumed one, a report",
    "peers": "a peer that crashes (by four signals) or hangs",
    "broken_kernels": "a kernel that does not build",
    "little_memory": "a device with memory for nothing, or for little, for each system",
    "oclgrind": "each system under Oclgrind: invalid accesses, data races, misuse of the API",
}
TABLES = {
    "faults": "Faults",
    "systems": "Damaged surfaces, by system",
    "readers": "Damaged files, by reader",
}


def tables(record):
    """A table for each kind of the record, in Markdown, with its totals."""
    lines = []
    for kind, title in TABLES.items():
        more = ("ok", "refused") if kind != "faults" else ("while running",)
        lines += [
            "",
            f"## {title}",
            "",
            "| | " + " | ".join(("tries", *more, "losses", "commit")) + " |",
        ]
        lines.append("| --- |" + " ---: |" * (len(more) + 2) + " --- |")
        found = record[kind]
        for name in [one for one in FAULTS if one in found] or sorted(found):
            one = found[name]
            counts = [one.get(key.replace(" ", "_")) for key in ("tries", *more)]
            told = ["" if n is None else f"{n:,}" for n in (*counts, len(one["losses"]))]
            tells = FAULTS.get(name, f"`{name}`")
            if "kernels" in one:
                tells += f" ({one['kernels']} of {one['kernels_written']} kernels run)"
            lines.append("| " + " | ".join([tells, *told, f"`{one['commit']}`"]) + " |")
        total = sum(one["tries"] for one in found.values())
        lost = sum(len(one["losses"]) for one in found.values())
        lines += ["", f"{total:,} tries, {lost} losses."]
    return "\n".join(lines)
