# The README's steps in an image: docker build -t radar-service . && docker run -p 8000:8000 radar-service
FROM python:3.11-slim
RUN useradd --create-home radar
WORKDIR /home/radar/radar-service
COPY --chown=radar . .
USER radar
RUN python3 -m venv .venv && .venv/bin/pip install --no-cache-dir .
EXPOSE 8000
HEALTHCHECK --interval=10s --timeout=3s --start-period=20s \
  CMD [".venv/bin/python", "-c", "import urllib.request as u; u.urlopen('http://127.0.0.1:8000/api/health', timeout=2)"]
STOPSIGNAL SIGTERM
CMD [".venv/bin/radar-service", "serve", "--host", "0.0.0.0"]
