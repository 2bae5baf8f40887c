"""The reports in a browser, at the widths of a laptop and a phone, in dark mode and on paper."""

import shutil

import pytest

pytest.importorskip('matplotlib', reason='reports need matplotlib: pip install matplotlib')
pytest.importorskip('jinja2', reason='reports need Jinja: pip install jinja2')

SCREENS = {'laptop': {'viewport': {'width': 1280, 'height': 800}},
           'phone': {'viewport': {'width': 360, 'height': 640}, 'is_mobile': True,
                     'has_touch': True, 'color_scheme': 'dark'}}
FIGURES = {'evaluation': 14, 'calibration': 3}
BEYOND = """width => [...document.querySelectorAll('main *, header *, footer *')].filter(
    one => one.getBoundingClientRect().right > width + 0.5 && !one.closest('.scroll')
).map(one => one.outerHTML.slice(0, 70))"""

BRIGHTNESS = """image => {  // mean of a figure, 0 to 1
  const context = document.createElement('canvas').getContext('2d');
  context.drawImage(image, 0, 0, 300, 150);
  const pixels = context.getImageData(0, 0, 300, 150).data.filter((_, i) => i % 4 < 3);
  return pixels.reduce((sum, value) => sum + value, 0) / pixels.length / 255;
}"""


@pytest.fixture(scope='module')
def browser():
    """Return the machine's Chromium, without a window."""
    playwright_api = pytest.importorskip('playwright.sync_api', reason='needs Playwright')
    names = ('chromium', 'chromium-browser', 'google-chrome')
    found = [path for path in map(shutil.which, names) if path]
    if not found:
        pytest.skip(f'no browser: none of {", ".join(names)} is installed')
    with playwright_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found[0])
        yield browser
        browser.close()


@pytest.fixture(params=['evaluation-laptop', 'evaluation-phone', 'calibration-phone'],
                scope='module')
def page(request, browser, evaluation_folder, calibration_page):
    """Return each page on a screen, unfolded, and the problems of loading it."""
    kind, screen = request.param.split('-')
    page = browser.new_page(**SCREENS[screen])
    page.kind, page.is_dark, page.wrong, page.requests = kind, screen == 'phone', [], []
    page.file = evaluation_folder / 'report.html' if kind == 'evaluation' else calibration_page
    page.on('console', lambda message: page.wrong.append(message.text))
    page.on('pageerror', lambda error: page.wrong.append(str(error)))
    page.on('request', lambda asked: page.requests.append(asked.url))
    page.goto(page.file.as_uri())
    page.locator('details').evaluate_all('all => all.forEach(one => { one.open = true; })')
    yield page
    page.close()


def test_nothing_goes_wrong_and_nothing_is_fetched(page):
    assert page.wrong == []
    assert [url for url in page.requests if not url.startswith('data:')] == [page.file.as_uri()]


def test_all_fits_on_the_screen(page):
    width = page.viewport_size['width']
    assert page.evaluate('document.documentElement.scrollWidth') <= width
    assert page.evaluate(BEYOND, width) == []
    assert page.evaluate("""[...document.querySelectorAll('td')].filter(
        one => one.scrollWidth > one.clientWidth + 1).map(one => one.textContent)""") == []


def test_figures_are_legible_in_the_color_scheme_of_the_page(page):
    figures = page.locator('.figure img').evaluate_all(f"""all => all.map(one => {{
        const box = one.getBoundingClientRect();
        return [box.x, box.width, box.height, one.naturalWidth, ({BRIGHTNESS})(one)];
    }})""")
    assert len(figures) == FIGURES[page.kind]
    for _, width, height, natural, brightness in figures:
        assert 250 < width < 640 and 130 < height < 800
        assert 9.5 * 96 / 72 * width / natural > 9.0  # smallest letters [px]
        assert brightness < 0.3 if page.is_dark else brightness > 0.7
    if page.kind == 'evaluation':  # side by side where there is room
        assert len({round(x) for x, *_ in figures}) == (1 if page.is_dark else 3)
    ink, paper = (sum(map(int, color[4:-1].split(','))) for color in page.evaluate(
        '[getComputedStyle(document.body).color, getComputedStyle(document.body).backgroundColor]'
    ))
    assert (ink > paper + 400) if page.is_dark else (paper > ink + 400)


def test_a_figure_opens_enlarged_and_closes_again(page):
    figure, lens = page.locator('.figure').nth(1), page.locator('dialog')
    small = figure.locator('img').bounding_box()['width']
    for close in (lambda: page.keyboard.press('Escape'), lambda: lens.locator('img').click()):
        figure.click()
        assert lens.locator('img').bounding_box()['width'] >= max(
            1.5 * small, page.viewport_size['width'] - 20)
        close()
        assert not lens.is_visible()


def test_a_link_unfolds_its_recording(page):
    if page.kind == 'evaluation':
        page.locator('details.recording').evaluate_all(
            'all => all.forEach(one => { one.open = false; })')
        page.locator('a[href="#recording-2"]').first.click()
        page.locator('#recording-2[open]').wait_for()
        assert page.locator('#recording-2 img').first.is_visible()
        assert not page.locator('#recording-1 img').first.is_visible()


def test_an_address_unfolds_its_recording(browser, evaluation_folder):
    page = browser.new_page()
    page.goto((evaluation_folder / 'report.html').as_uri() + '#recording-2')
    page.locator('#recording-2[open]').wait_for()
    page.close()


def test_nothing_is_cut_on_paper(page):
    page.emulate_media(media='print')
    page.set_viewport_size({'width': 703, 'height': 1032})  # A4 less margins of 12 mm, at 96 dpi
    assert page.evaluate(BEYOND.replace('.scroll', 'head'), 703) == []  # nothing scrolls there
