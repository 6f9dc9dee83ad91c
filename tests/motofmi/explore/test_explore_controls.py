"""The controls of the explore page: sliders, choices, address, keyboard, downloads."""

import csv
import io
from xml.etree import ElementTree as Xml

import pytest

import motofmi as mf
from tests.explore_page import SPEEDS, Opened, in_browser


@in_browser
def test_what_the_vehicle_cannot_have_is_not_offered(page):
    window = page.window
    window.select_option("#choose-vehicle", "benchmark_bicycle")
    offered = "name => !document.querySelector(`#choose-device option[value=${name}]`).disabled"
    assert not window.evaluate(offered, "roll_1971") and window.evaluate(offered, "full_mean_2011")
    assert "has no output" in window.text_content("#parameters")
    window.select_option("#choose-device", "mean_2011")
    window.select_option("#choose-device-2", "damper_low_2011")
    page.drawn()
    assert "B=benchmark_bicycle;mean_2011,damper_low_2011" in window.url
    assert "benchmark_bicycle with mean_2011 and damper_low_2011" in window.text_content("#charts")


@in_browser
def test_every_slider_moves_a_curve(page):
    window = page.window
    for device, first in (("mean_2011", "p-"), ("damper_low_2011", "p-device")):
        window.click("#reset")
        window.select_option("#choose-device", device)
        page.drawn()
        window.evaluate("document.querySelectorAll('#parameters details').forEach(d => d.open = true)")
        for key in window.evaluate(
            "first => [...document.querySelectorAll('#parameters input[type=range]')].map(i => i.id).filter(id => id.startsWith(first))",
            first,
        ):
            before = page.curves()
            window.evaluate(
                "id => { const s = document.getElementById(id); s.value = 0.3 * s.min + 0.7 * s.max; s.dispatchEvent(new Event('input')); }",
                key,
            )
            page.drawn()
            # what a rider adds to the steer inertia is bound to the vehicle's parameter of that name
            bound = key == "p-vehicle-added_steer_inertia" and device == "mean_2011"
            assert (page.curves() != before) != bound, key


@in_browser
def test_the_speed_the_view_and_the_mode_are_chosen(page):
    window = page.window
    window.evaluate(
        "() => { const s = document.getElementById('speed'); s.value = 50; s.dispatchEvent(new Event('input')); }"
    )
    page.drawn()
    assert "50.0 m/s" in window.text_content("#readings")
    window.click("#view [data-value=speed]")
    page.drawn()
    assert "frequency [Hz]" in window.text_content("#charts") and window.locator("#charts .band").count() > 0
    window.click("#mode [data-value='A weave']")
    page.drawn()
    assert "weave of A" in window.text_content("#motion-text")
    assert window.locator("#motion .motorcycle path").count() > 30 and window.locator("#phasors .arrow").count() == 3


@in_browser
def test_the_keyboard_moves_a_slider_and_its_number(page):
    slider = page.window.locator("#p-vehicle-trail")
    slider.focus()
    before = float(slider.input_value())
    page.window.keyboard.press("ArrowRight")
    page.drawn()
    assert float(slider.input_value()) > before and "vehicle.trail" in page.window.url


@in_browser
def test_a_number_beside_a_slider_shows_the_value_that_is_used(page):
    """A number outside of the parameter's bounds is replaced by the bound, an empty one by the value before."""
    number = page.window.locator("#p-vehicle-trail + input")
    for typed in ("1e9", ""):
        number.fill(typed)
        number.press("Enter")
        page.drawn()
        used = page.window.evaluate("page.settings.value(page.settings.edit, 'vehicle.trail')")
        assert used < 1e9 and float(number.input_value()) == pytest.approx(used, rel=1e-4)  # five digits are shown


@in_browser
def test_an_address_reproduces_the_view(browser, written, page):
    address = "#view=speed&speed=42.5&side=A&mode=wobble&A=reference_2011;damper_low_2011;device.damping:9&B=benchmark_bicycle;none"
    again = Opened(browser, written.path, address)
    state = again.window.evaluate("({...page.settings, data: 0})")
    assert (state["view"], state["speed"], state["side"], state["mode"]) == ("speed", 42.5, "A", "wobble")
    assert state["A"] == {"vehicle": "reference_2011", "device": "damper_low_2011", "values": {"device.damping": 9}}
    assert state["B"] == {"vehicle": "benchmark_bicycle", "device": "none", "values": {}}
    assert again.curves() != page.curves() and again.complaints == []
    again.window.close()


@in_browser
def test_the_tables_and_the_drawing_are_downloaded(page):
    with page.window.expect_download() as download:
        page.window.click("#csv")
    rows = list(csv.DictReader(io.StringIO(download.value.path().read_text("utf-8"))))
    weave = {
        float(r["speed [m/s]"]): float(r["real [1/s]"])
        for r in rows
        if r["configuration"][0] == "B" and r["mode"] == "weave"
    }
    expected = mf.modes("sharp_1971", "rider:mean_2011", SPEEDS)["weave"].eigenvalue.real
    assert [weave[v] for v in SPEEDS] == pytest.approx(list(expected), rel=1e-9)
    with page.window.expect_download() as download:
        page.window.click("#svg")
    drawing = Xml.fromstring(download.value.path().read_text("utf-8"))
    assert len(drawing.findall(".//{*}path")) > 9 and "var(--weave)" in Xml.tostring(drawing, "unicode")
