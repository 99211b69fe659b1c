import pytest

from fullwell.errors import UsageError
from fullwell.report.emva_items import ITEMS
from fullwell.report.emva_xml_reading import read_reference_results

LOWER = """<results>
  <sensitivity>
    <K><section>sensitivity</section><short>System gain</short><symbol>K</symbol><unit>$DN/e^-$</unit>
       <value>0.0988</value></K>
    <DR_dB><section>sensitivity</section><value>52.2</value></DR_dB>
    <index_u_ysat><section>sensitivity</section><value>10</value></index_u_ysat>
    <u_p_min_area><section>sensitivity</section><value>None</value></u_p_min_area>
  </sensitivity>
  <spatial><DSNU1288><section>spatial</section><value>nan</value></DSNU1288></spatial>
  <defect_pixel><histogram_DSNU><section>defect_pixel</section>
    <data><bins>0 1</bins><values>2 3</values></data></histogram_DSNU></defect_pixel>
</results>"""

CAMEL = """<Results>
  <Sensitivity><K><Short>System gain</Short><Symbol>K</Symbol><Value>0,0988</Value></K></Sensitivity>
</Results>"""


def written(folder, text):
    path = folder / "result.xml"
    path.write_text(text, encoding="utf-8")
    return path


def test_figures_become_rows_and_what_is_nan_is_named(tmp_path):
    results = read_reference_results(written(tmp_path, LOWER))
    assert [(row.quantity, row.measured.value, row.measured.unit) for row in results.rows] == [
        ("system_gain", 0.0988, "DN/e-"),
        ("dynamic_range", 52.2, "dB"),
    ]
    assert {row.method for row in results.rows} == {"emva1288-py-1.0"}
    assert "u_p_min_area" in results.findings[0].message
    assert "DSNU1288" in results.findings[0].message


def test_camel_case_and_a_decimal_comma_are_read(tmp_path):
    results = read_reference_results(written(tmp_path, CAMEL))
    assert results.rows[0].measured.value == 0.0988


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<results><a", "no valid XML"),
        ("<html><body/></html>", "its root is html"),
        ("<results></results>", "holds no figure"),
        ("<!DOCTYPE results [<!ENTITY a 'x'>]><results/>", "no document type"),
        ("<results><s><K><value>abc</value></K></s></results>", "K has the value 'abc'"),
    ],
)
def test_what_is_no_result_file_is_refused_with_the_reason(tmp_path, text, words):
    with pytest.raises(UsageError, match=words):
        read_reference_results(written(tmp_path, text))


def test_every_item_has_a_name_of_its_own():
    tags = [item.tag.lower() for item in ITEMS]
    assert len(tags) == len(set(tags)) == 57
