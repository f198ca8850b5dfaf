"""The look of the window's own parts, beside the application's style."""

from ..palette import Theme


def window_style(colours: Theme) -> str:
    """What the parts of the window add to the application's style."""
    return f"""
    QLabel#soft {{ color: {colours.soft_ink}; }}
    QLabel#group-heading {{ font-weight: 600; }}
    QLabel#changed-dot {{ color: {colours.accent}; }}
    QLabel#page-heading, QLabel#question {{ font-size: 18px; font-weight: 600; }}
    QLabel#placeholder {{ color: {colours.soft_ink}; font-size: 15px; }}
    QWidget#rail {{ background: {colours.panel}; border-right: 1px solid {colours.line}; }}
    QWidget#rail QToolButton {{ padding: 6px 0px; border-radius: 6px; color: {colours.soft_ink}; font-size: 12px; }}
    QWidget#rail QToolButton:checked {{ background: {colours.raised}; color: {colours.ink}; }}
    QWidget#status-line {{ background: {colours.panel}; border-top: 1px solid {colours.line}; }}
    QFrame#message-bar {{ background: {colours.raised}; border: none; border-bottom: 2px solid {colours.wrong}; }}
    QWidget#status-line QToolButton {{ padding: 4px 8px; }}
    QWidget#status-line QToolButton::menu-indicator {{ image: none; }}
    QTableView#matches QHeaderView::section {{ padding: 4px 2px; }}
    QPushButton#plain {{ border: none; background: transparent; color: {colours.soft_ink}; padding: 2px 4px; }}
    QPushButton#plain:hover {{ color: {colours.ink}; text-decoration: underline; }}
    QPushButton#choice {{ border: none; border-bottom: 2px solid transparent; border-radius: 0; background: transparent;
                          color: {colours.soft_ink}; padding: 6px 8px; }}
    QPushButton#choice:hover {{ color: {colours.ink}; }}
    QPushButton#choice:checked {{ color: {colours.ink}; border-bottom-color: {colours.accent}; }}
    QPushButton#choice:focus {{ border-bottom-color: {colours.line}; }}
    QPushButton#choice:checked:focus {{ border-bottom-color: {colours.accent}; }}
    QDialog#calm, QDialog#calm QScrollArea, QDialog#calm QScrollArea > QWidget > QWidget {{ background: {colours.paper}; }}
    QLabel#field-error {{ color: {colours.wrong}; }}
    QLabel#summary {{ background: {colours.panel}; border-radius: 4px; padding: 8px 12px; }}
    QFrame#wizard-rail {{ background: {colours.panel}; border-right: 1px solid {colours.line}; }}
    QPushButton#wizard-step {{ border: none; background: transparent; text-align: left; color: {colours.soft_ink}; padding: 8px; }}
    QPushButton#wizard-step:hover {{ color: {colours.ink}; }}
    QPushButton#wizard-step:checked {{ color: {colours.ink}; background: {colours.raised}; border-radius: 4px; }}
    QFrame#calculator {{ border: 1px solid {colours.line}; border-radius: 6px; }}
    QFrame#calculator QLabel#summary {{ background: {colours.panel}; }}
    QMenuBar {{ background: {colours.panel}; border-bottom: 1px solid {colours.line}; }}
    """
