from lodbench.harness.plan.table import tables
from lodbench.harness.report.document import document
from tests.harness.records import run


def test_every_table_names_its_module_and_has_status_columns_and_unique_keys():
    for name, table in tables().items():
        assert __import__(f"lodbench.harness.tables.{name}", fromlist=["x"]).TABLE is table
        keys = [column["key"] for column in document(table, run())["columns"]]
        assert len(keys) == len(set(keys))
        assert {"system", "wall_s", "status", "reason"} <= set(keys)


def test_every_table_has_different_groups_with_different_labels():
    for table in tables().values():
        for quick in (False, True):
            names = [made.name for made in table.groups(quick)]
            assert len(set(names)) == len(names)
            for made in table.groups(quick):
                labels = [subject.name for subject in made.subjects]
                assert len(set(labels)) == len(labels)


def test_quick_run_measures_every_table_on_smaller_inputs():
    for table in tables().values():
        sizes = []
        for quick in (True, False):
            entries = [group.found().triangles or 0 for group in table.groups(quick)]
            assert entries, table.id
            sizes.append(max(entries))
        assert sizes[0] <= min(sizes[1], 1_100_000), table.id
