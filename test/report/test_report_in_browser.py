"""The reports as a browser shows them, at a laptop's and at a phone's width."""

from itertools import product
import shutil

from baxter_dynamics_ros.model.joints import JOINTS
import pytest

pytest.importorskip('matplotlib', reason='reports need matplotlib: pip install matplotlib')
pytest.importorskip('jinja2', reason='reports need Jinja: pip install jinja2')
playwright_api = pytest.importorskip(
    'playwright.sync_api', reason='looking at reports needs playwright: pip install playwright')

LONG = 'a_recording_with_a_name_that_has_no_place_to_break_' * 3
SCREENS = {'laptop': {'viewport': {'width': 1280, 'height': 800}},
           'phone': {'viewport': {'width': 390, 'height': 844}, 'is_mobile': True,
                     'has_touch': True, 'device_scale_factor': 2},
           'small_phone': {'viewport': {'width': 360, 'height': 640}, 'is_mobile': True,
                           'has_touch': True}}
# What is on each page: figures, and words.
PAGES = {
    'evaluation': (15 + 8, (
        '1 of 2 recordings with warnings', '<b>look</b>', 'mean |e|', 'paper, set 3', '0.0710',
        'first difference', 'Coriolis', 'not_this_arm', 'Agreement',
        'This recording holds no valid measured effort', *JOINTS)),
    'calibration': (7 + 6, (
        '22 warnings', '14 more', '<look>', '<script>', 'All 30 recordings', 'Record next',
        'Velocity lag', '+ Dahl', '1.200', 'm/s²', 'moment y', 's1 was there', 'How to use it',
        *JOINTS)),
}

LOOKS = [*product(['evaluation'], SCREENS), ('calibration', 'laptop'), ('calibration', 'phone')]

# How much of a figure is neither white nor a shade of grey, 0 to 1.
COLORED = """image => {
  const canvas = document.createElement('canvas');
  canvas.width = 300;
  canvas.height = 200;
  const context = canvas.getContext('2d');
  context.drawImage(image, 0, 0, 300, 200);
  const pixels = context.getImageData(0, 0, 300, 200).data;
  let n = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    const [r, g, b] = pixels.slice(i, i + 3);
    if (Math.max(r, g, b) - Math.min(r, g, b) > 40) n += 1;
  }
  return n / 60000;
}"""


@pytest.fixture(scope='module')
def browser():
    """Return the machine's Chromium, without a window."""
    names = ('chromium', 'chromium-browser', 'google-chrome')
    found = [path for path in map(shutil.which, names) if path]
    if not found:
        pytest.skip(f'no browser: none of {", ".join(names)} is installed')
    with playwright_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found[0])
        yield browser
        browser.close()


@pytest.fixture(scope='module')
def report(evaluate, tmp_path_factory):
    """Return the report on two recordings, the second without effort."""
    from baxter_dynamics_ros.report.evaluation_report import Total, write_evaluation
    folder = tmp_path_factory.mktemp('report')
    first = evaluate(LONG, warnings=['stamps <b>look</b> like times of arrival'])
    second = evaluate('second', effort=False)
    total = Total('right', first.methods, first.estimators, first.shares)
    write_evaluation(folder, [first, second], total, 'baxter_dynamics evaluate ' + LONG,
                     'defaults of the package')
    return folder / 'report.html'


@pytest.fixture(scope='module')
def reports(report, calibration_report):
    """Return the pages to look at, by kind."""
    return {'evaluation': report, 'calibration': calibration_report}


@pytest.fixture(params=LOOKS, ids='-'.join, scope='module')
def page(request, browser, reports):
    """Return each page on each screen, and what went wrong while it was looked at."""
    kind, screen = request.param
    context = browser.new_context(**SCREENS[screen])
    page = context.new_page()
    page.kind, page.wrong, page.requests = kind, [], []
    page.on('console', lambda message: page.wrong.append(message.text))
    page.on('pageerror', lambda error: page.wrong.append(str(error)))
    page.on('requestfailed', lambda asked: page.wrong.append(asked.url))
    page.on('request', lambda asked: page.requests.append(asked.url))
    page.goto(reports[kind].as_uri())
    page.locator('details').evaluate_all('all => all.forEach(one => { one.open = true; })')
    yield page
    context.close()


def test_nothing_is_wider_than_the_screen(page, tmp_path):
    page.screenshot(path=tmp_path / 'report.png', full_page=True, scale='css')
    assert (tmp_path / 'report.png').stat().st_size > 100_000
    width = page.viewport_size['width']
    assert page.evaluate('innerWidth') == width
    assert page.evaluate('document.documentElement.scrollWidth') <= width
    # Beyond the screen is only what scrolls inside a box of its own.
    beyond = page.evaluate("""[...document.querySelectorAll('main *, header *, footer *')].filter(
        one => one.getBoundingClientRect().right > innerWidth + 0.5 && !one.closest('.scroll')
    ).map(one => one.outerHTML.slice(0, 80))""")
    assert beyond == []


def test_every_figure_is_drawn_and_its_letters_can_be_read(page):
    figures = page.locator('a.figure img').evaluate_all(f"""all => all.map(one => {{
        const box = one.getBoundingClientRect();
        return [box.width, box.height, one.naturalWidth, ({COLORED})(one)];
    }})""")
    assert len(figures) == PAGES[page.kind][0]
    for width, height, natural, colored in figures:
        assert natural > 400
        assert 250 < width < 640 and 130 < height < 800
        assert 9.5 * 96 / 72 * width / natural > 9.0  # the smallest letters [px]
        assert colored > 0.003


def test_figures_stand_side_by_side_where_there_is_room(page):
    boxes = [image.bounding_box() for image in page.locator('.figures').first.locator('img').all()]
    columns = len({round(box['x']) for box in boxes})
    assert len(boxes) == len(JOINTS)
    assert columns == (3 if page.viewport_size['width'] == 1280 else 1)


def test_nothing_goes_wrong_and_nothing_is_fetched(page, reports):
    assert page.wrong == []
    assert [url for url in page.requests if not url.startswith('data:')] == [
        reports[page.kind].as_uri()]


def test_the_tables_and_warnings_are_there(page):
    text = page.locator('main').inner_text()
    for words in PAGES[page.kind][1]:
        assert words in text
    for table in page.locator('table').all():
        for cell in table.locator('td').all()[:3]:
            assert cell.bounding_box()['width'] > 25


def test_numbers_do_not_touch_their_neighbours(page):
    touching = page.evaluate("""[...document.querySelectorAll('td')].filter(
        one => one.scrollWidth > one.clientWidth + 1).map(one => one.textContent)""")
    assert touching == []


def test_a_figure_opens_large_and_closes_again(page):
    figure, lens = page.locator('a.figure').nth(1), page.locator('dialog.lens')
    assert not lens.is_visible()
    small = figure.locator('img').bounding_box()['width']
    for close in (lambda: page.keyboard.press('Escape'),
                  lambda: page.get_by_role('button', name='Close').click(),
                  lambda: lens.locator('img').click()):
        figure.click()
        assert lens.is_visible()
        large = lens.locator('img').bounding_box()['width']
        assert large >= max(2 * small, page.viewport_size['width'] - 20)
        assert page.evaluate('document.documentElement.scrollWidth') <= (
            page.viewport_size['width'])
        close()
        assert not lens.is_visible()


@pytest.mark.parametrize('page', LOOKS[:3], ids='-'.join, indirect=True)
def test_a_link_unfolds_its_recording(page):
    page.locator('details.recording').evaluate_all('all => all.forEach(one => {one.open = false})')
    page.locator('a[href="#recording-2"]').first.click()
    page.wait_for_function("document.getElementById('recording-2').open")
    assert page.locator('#recording-2 img').first.is_visible()
    assert not page.locator('#recording-1 img').first.is_visible()
