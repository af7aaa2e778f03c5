@echo off
rem SPDX-License-Identifier: Apache-2.0
rem Tells the Vulkan loader where the layer is: the folder of this script.
setlocal
set root=HKCU
set verb=add
set implicit=

:options
if "%~1"=="" goto begin
if /i "%~1"=="/machine" set root=HKLM& shift & goto options
if /i "%~1"=="/implicit" set implicit=yes& shift & goto options
if /i "%~1"=="/remove" set verb=delete& shift & goto options
echo usage: register.cmd [/machine] [/implicit] [/remove]
echo.
echo Registers the layer for this user, so that applications and VK_INSTANCE_LAYERS can
echo enable VK_LAYER_ASSAY_validation. The folder must stay where it is.
echo   /machine   for all users; needs an administrator. Programs that run as administrator
echo              find only layers that are registered this way.
echo   /implicit  also the implicit layer, which VK_ASSAY_ENABLE=1 enables
echo   /remove    removes all of that
exit /b 2

:begin
set key=%root%\SOFTWARE\Khronos\Vulkan
if %verb%==delete goto remove
if not exist "%~dp0VkLayer_assay.dll" echo register.cmd: there is no VkLayer_assay.dll beside this script& exit /b 1
reg add "%key%\ExplicitLayers" /v "%~dp0VkLayer_assay.json" /t REG_DWORD /d 0 /f
if errorlevel 1 exit /b 1
if "%implicit%"=="" exit /b 0
reg add "%key%\ImplicitLayers" /v "%~dp0VkLayer_assay_implicit.json" /t REG_DWORD /d 0 /f
if errorlevel 1 exit /b 1
exit /b 0

:remove
reg delete "%key%\ExplicitLayers" /v "%~dp0VkLayer_assay.json" /f >nul 2>nul
reg delete "%key%\ImplicitLayers" /v "%~dp0VkLayer_assay_implicit.json" /f >nul 2>nul
exit /b 0
