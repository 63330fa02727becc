from pigbench.report.order import ordered


def test_names_are_in_order_and_variants_where_their_method_is():
    names = ["z", "b (2)", "a", "b", "q", "b"]
    assert ordered(names, ["b", "q"]) == ["b", "b (2)", "q", "a", "z"]
